// See cutaway.h.
#include <tools/render/cutaway.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>

namespace scree::render {
namespace {

constexpr std::size_t kMostSamples = 512;  // of shapes
constexpr int kMostLayers = 8;             // of walls behind each other
constexpr float kBefore = 0.98f;           // of the way to a shape: what is farther off is what it lies on

// Some of the subject's shapes.
struct Samples {
  std::vector<Vec3> middles;
  std::vector<BodyId> owners;
};

Samples sample(const Subject& subject) {
  const std::size_t shapes = subject.owners.size();
  const std::size_t stride = std::max<std::size_t>(1, shapes / kMostSamples);
  Samples samples;
  for (std::size_t shape = 0; shape < shapes; shape += stride) {
    Vec3 sum;
    for (int corner = 0; corner < Subject::kCorners; ++corner)
      sum += subject.corners[Subject::kCorners * shape + static_cast<std::size_t>(corner)];
    samples.middles.push_back(sum / float{Subject::kCorners});
    samples.owners.push_back(subject.owners[shape]);
  }
  return samples;
}

bool has(const std::vector<ShapeId>& shapes, ShapeId shape) {
  return std::binary_search(shapes.begin(), shapes.end(), shape);
}

// Shapes that more than a tenth of the rays meet first, one of each sample; ascending.
std::vector<ShapeId> often_met(const World& world, const std::vector<Ray>& rays, const Samples& samples,
                               const QueryOptions& options, Workers& workers) {
  std::vector<std::optional<CastHit>> hits(rays.size());
  cast_rays(world, rays, hits, workers, options);
  std::map<ShapeId, std::size_t> counts;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i] && hits[i]->body != samples.owners[i]) ++counts[hits[i]->shape];
  }
  std::vector<ShapeId> shapes;
  for (const auto& [shape, count] : counts) {
    if (10 * count > rays.size()) shapes.push_back(shape);
  }
  return shapes;
}

}  // namespace

std::vector<ShapeId> find_walls(const World& world, Vec3 eye, const Subject& subject, Workers& workers) {
  const Samples samples = sample(subject);
  std::vector<Ray> down, sight;
  for (const Vec3& middle : samples.middles) {
    down.push_back({middle, -2.0f * subject.reach * subject.up});
    sight.push_back({eye, kBefore * (middle - eye)});
  }
  QueryOptions options{.types = BodyTypes::fixed | BodyTypes::kinematic, .start_inside = StartInside::skip};
  const std::vector<ShapeId> ground = often_met(world, down, samples, options, workers);
  std::vector<ShapeId> walls;
  options.predicate = [&](ShapeId shape, BodyId) { return !has(walls, shape); };
  for (int layer = 0; layer < kMostLayers; ++layer) {
    std::vector<ShapeId> found = often_met(world, sight, samples, options, workers);
    std::erase_if(found, [&](ShapeId shape) { return has(ground, shape); });
    if (found.empty()) break;
    walls.insert(walls.end(), found.begin(), found.end());
    std::sort(walls.begin(), walls.end());
  }
  return walls;
}

}  // namespace scree::render
