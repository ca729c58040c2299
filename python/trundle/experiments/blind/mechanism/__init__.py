"""The blind benchmark of mechanisms: recordings of arms and benches with hidden effects."""
