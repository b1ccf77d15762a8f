"""Sources of meshes: boxes, muscles, and files.

Every mesh they give has passed `myobridge.mesh_check.check_mesh`, and every facet of the boundary of those that are not
read from a file belongs to a named part.
"""
