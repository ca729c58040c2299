"""Generator of recordings of furniture: rigid grasps, one kind of instruments, MuJoCo."""
