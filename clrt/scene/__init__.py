"""The scene as the user means it: cameras, lights, materials and shapes, checked."""
