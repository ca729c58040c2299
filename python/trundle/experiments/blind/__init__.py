"""The concealed proof: recordings that MuJoCo makes with an effect hidden, diagnosed, and scored."""
