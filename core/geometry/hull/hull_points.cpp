// Extreme points by Qhull (Barber, Dobkin, Huhdanpaa: The Quickhull algorithm for convex hulls, 1996).
//
// Qhull only selects points: faces, order and bits come from hull_triangles and hull_faces.
#include <core/geometry/hull/hull_stages.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <numeric>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace scree {

namespace {

// Fewer points skip Qhull and go to the exact stage directly.
constexpr std::size_t kFewPoints = 64;

// Frees all that Qhull allocates. Qhull reports errors by longjmp only within qh_new_qhull, so it jumps over
// no frame of ours.
class Session {
 public:
  Session() {
    // Without a stream of its own Qhull writes to standard error.
    messages_ = open_memstream(&text_, &text_size_);
    if (messages_ == nullptr) throw std::bad_alloc();
    qh_zero(&qhull_, messages_);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() {
    int long_blocks = 0, long_bytes = 0;
    qh_freeqhull(&qhull_, !qh_ALL);
    qh_memfreeshort(&qhull_, &long_blocks, &long_bytes);
    std::fclose(messages_);
    std::free(text_);
  }

  // Returns Qhull's exit code.
  int run(std::vector<double>& coordinates) {
    // Pp: no warnings about precision; Q12: wide facets are no error.
    char command[] = "qhull Pp Q12";
    const int points = static_cast<int>(coordinates.size() / 3);
    return qh_new_qhull(&qhull_, 3, points, coordinates.data(), False, command, nullptr, messages_);
  }
  std::vector<std::int32_t> corners() {
    std::vector<std::int32_t> indices;
    indices.reserve(static_cast<std::size_t>(qhull_.num_vertices));
    for (const vertexT* vertex = qhull_.vertex_list; vertex != nullptr && vertex->next != nullptr;
         vertex = vertex->next) {
      indices.push_back(qh_pointid(&qhull_, vertex->point));
    }
    std::sort(indices.begin(), indices.end());
    return indices;
  }

 private:
  qhT qhull_;
  std::FILE* messages_ = nullptr;
  char* text_ = nullptr;
  std::size_t text_size_ = 0;
};

}  // namespace

std::vector<std::int32_t> find_extreme_points(std::span<const GridPoint> points) {
  std::vector<std::int32_t> all(points.size());
  std::iota(all.begin(), all.end(), 0);
  if (points.size() <= kFewPoints) return all;
  std::vector<double> coordinates;
  coordinates.reserve(3 * points.size());
  for (const GridPoint& p : points) coordinates.insert(coordinates.end(), p.begin(), p.end());
  const auto session = std::make_unique<Session>();  // several kilobytes
  const int code = session->run(coordinates);
  if (code == qh_ERRmem) throw std::bad_alloc();
  if (code != qh_ERRnone) return all;
  std::vector<std::int32_t> corners = session->corners();
  return corners.size() < 4 ? all : corners;
}

}  // namespace scree
