"""First stage between stimulation and activation."""
