"""The wide blind benchmark: instruments, conventions, engines and effects drawn at random for every case."""
