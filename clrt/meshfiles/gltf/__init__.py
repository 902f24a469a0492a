"""glTF 2.0, .gltf and .glb: triangles, and what its materials, cameras and lights look like."""
