"""Generator of varied recordings: random outlines, grasps and instruments, two engines."""
