// Backends: what a step can run on. Results must not depend on it.
#pragma once

#include <scree/scree.h>
#include <tools/scenes/random.h>

#include <cstddef>
#include <string>
#include <vector>

namespace scree::soak {

struct Backend {
  Isa isa = Isa::scalar;
  int threads = 1;
};

std::string name_of(Backend backend);     // "avx2 x 3"
std::string options_of(Backend backend);  // "--isa avx2 --threads 3"

/// Every instruction set that runs here, each with several thread counts, and the workers for them.
class Backends {
 public:
  Backends();

  std::size_t count() const { return backends_.size(); }
  std::size_t random(scenes::Random& random) const {
    return random.below(static_cast<std::uint32_t>(count()));
  }
  Backend at(std::size_t index) const { return backends_[index]; }
  Workers& workers(std::size_t index) { return workers_[index]; }

 private:
  std::vector<Backend> backends_;
  std::vector<Workers> workers_;
};

}  // namespace scree::soak
