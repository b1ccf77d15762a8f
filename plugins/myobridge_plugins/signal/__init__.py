"""Functions of time: activations, loads, prescribed stretches."""
