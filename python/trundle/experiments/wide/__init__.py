"""The wide blind benchmark, with random instruments, conventions, engines and effects."""
