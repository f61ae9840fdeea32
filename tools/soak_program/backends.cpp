// See backends.h.
#include <tools/soak_program/backends.h>

namespace scree::soak {
namespace {

constexpr Isa kIsas[] = {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512};
constexpr int kThreadCounts[] = {1, 2, 3, 4, 8, 16};

}  // namespace

std::string name_of(Backend backend) {
  return std::string(isa_name(backend.isa)) + " x " + std::to_string(backend.threads);
}

std::string options_of(Backend backend) {
  return std::string("--isa ") + isa_name(backend.isa) + " --threads " + std::to_string(backend.threads);
}

Backends::Backends() {
  for (const Isa isa : kIsas) {
    if (!is_supported(isa)) continue;
    for (const int threads : kThreadCounts) {
      backends_.push_back({isa, threads});
      workers_.emplace_back(WorkersOptions{.threads = threads, .isa = isa});
    }
  }
}

}  // namespace scree::soak
