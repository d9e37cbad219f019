//! Mesh files back in: STL, PLY and OBJ, for `mcubes check`.
