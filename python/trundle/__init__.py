"""Push what you have never seen: physics-based models of wheeled furniture, learnt, diagnosed and used."""
