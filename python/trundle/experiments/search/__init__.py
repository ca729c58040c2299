"""Random search of the settings of a training, or of the adaptive agent (`trundle train --search`)."""
