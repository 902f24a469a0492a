"""OBJ and its libraries of materials, MTL."""
