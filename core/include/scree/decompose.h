// Approximate convex decomposition: from a closed triangle mesh to a few convex hulls, which a body can have
// as shapes.
#pragma once

#include <scree/export.h>
#include <scree/hull.h>
#include <scree/math_types.h>
#include <scree/mesh.h>

#include <cstddef>
#include <span>
#include <vector>

namespace scree {

/// How a mesh is decomposed. Its size is the largest extent of its bounds.
struct DecomposeOptions {
  /// In [0.001, 1]: a part is cut while its hull reaches farther from the solid than this share of the size.
  float concavity_share = 0.02f;
  float concavity = 0.0f;  ///< m, the same as a length, up to 1e5; above 0 it replaces the share
  int max_parts = 64;      ///< in [1, 1024]; where it is too few, the parts that fit best are joined
  /// In [4, 256], of each hull. A part with more is simplified as HullOptions says: its hull then lies within
  /// the part's own.
  int max_vertices = 64;
  /// In [16, 256]: cells along the size of the lattice on which hulls are searched for empty space. What is
  /// narrower than a cell may be overlooked. Memory, up to 134 MB, and time grow with its cube.
  int resolution = 64;
};

/// What a decomposition made of a mesh. Distances are measured on the finished hulls, to and from samples of
/// surfaces that lie at most a cell of the lattice apart.
struct DecomposeReport {
  std::size_t cuts = 0;               ///< planes that divided a part in two
  std::size_t merges = 0;             ///< pairs of parts that were joined again
  bool reached_limit = false;         ///< max_parts has kept parts that reach farther out than was asked for
  double concavity = 0.0;             ///< m, that was asked for
  double mesh_volume = 0.0;           ///< m^3, as mesh_mass has it: where parts overlap, they count twice
  double hull_volume = 0.0;           ///< m^3, sum of the hulls; where they overlap, they count twice
  double hulls_from_mesh = 0.0;       ///< m, how far a hull reaches out of the solid at most
  double mesh_from_hulls = 0.0;       ///< m, how far the mesh reaches out of the hulls at most
  std::size_t cut_vertices = 0;       ///< corners that max_vertices left out, of all hulls
  std::size_t dropped_parts = 0;      ///< left out: thinner than hulls can be
  std::size_t dropped_triangles = 0;  ///< left out: with fewer than three different corners, or in pairs that
                                      ///< cover each other back to back
  std::size_t joined_pieces = 0;      ///< pieces of a mesh of very many that were taken as one before any cut

  /// m, the larger one of both distances, as Hausdorff's.
  double distance() const { return hulls_from_mesh > mesh_from_hulls ? hulls_from_mesh : mesh_from_hulls; }
};

/// The hulls of a mesh, largest first, and how well they fit.
struct Decomposition {
  std::vector<Hull> hulls;  ///< in the frame of the mesh
  DecomposeReport report;   ///< what was done, and figures of quality
};

/// Divides what a closed mesh encloses into parts whose convex hulls together resemble it.
///
/// Cuts parts by planes, always the one whose hull reaches farthest out of the solid: planes along faces at
/// reentrant edges, through gaps, and of 13 directions, of which the one that leaves the least volume in the
/// two hulls is taken. Then joins parts whose common hull does not reach farther out than was asked for.
/// Planes and the merging are those of Mamou and Ghorbel, A simple and efficient approach for 3D mesh
/// approximate convex decomposition (2009), and Wei et al., Approximate convex decomposition for 3D meshes
/// with collision-aware concavity and tree search (2022). The hulls are those of the surface itself, clipped,
/// so that flat faces stay flat.
///
/// The solid is where the winding number is not zero: pieces may overlap, hollows are empty, and a mesh that
/// is inside out is the same solid. Equal meshes give equal hulls, in whatever order their vertices and
/// triangles are, and the same bits on every machine.
///
/// Throws Error where inspect_mesh does, on options out of range, where the mesh is not closed
/// (MeshReport::is_closed), with the first of its open edges, where it encloses nothing, and where no part of
/// it is thick enough for a hull.
SCREE_API Decomposition decompose(std::span<const Vec3> vertices, std::span<const MeshTriangle> triangles,
                                  const DecomposeOptions& options = {});

}  // namespace scree
