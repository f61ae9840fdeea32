// Serial stand-in while the crew is being written.
#include <parallel/crew.h>

#include <cstdlib>
#include <string>

namespace scree {

struct Workers::Impl {
  int threads = 1;
  Isa isa = Isa::scalar;
  const simd::Kernels* kernels = nullptr;
};

const char* isa_name(Isa isa) {
  constexpr const char* kNames[] = {"auto", "scalar", "sse2", "avx2", "avx512"};
  return kNames[static_cast<int>(isa)];
}

bool is_supported(Isa isa) {
  return isa == Isa::automatic ||
         simd::find_kernels(static_cast<simd::InstructionSet>(static_cast<int>(isa) - 1)) != nullptr;
}

Workers::Workers() : Workers(WorkersOptions{}) {}
Workers::Workers(int threads) : Workers(WorkersOptions{.threads = threads}) {}
Workers::Workers(const WorkersOptions& options) : impl_(std::make_shared<Impl>()) {
  impl_->kernels =
      options.isa == Isa::automatic
          ? &simd::widest_kernels()
          : simd::find_kernels(static_cast<simd::InstructionSet>(static_cast<int>(options.isa) - 1));
  if (impl_->kernels == nullptr) throw Error("unsupported instruction set");
  impl_->isa = static_cast<Isa>(static_cast<int>(impl_->kernels->instruction_set) + 1);
}
Workers::~Workers() = default;
Workers::Workers(Workers&&) noexcept = default;
Workers& Workers::operator=(Workers&&) noexcept = default;
int Workers::threads() const noexcept {
  return impl_->threads;
}
Isa Workers::isa() const noexcept {
  return impl_->isa;
}

Crew::Crew(Workers& workers) : kernels_(workers.impl_->kernels) {}
Crew::~Crew() = default;
void Crew::run_stage(int chunks, StageFunction function, void* context) {
  ++stages_;
  for (int chunk = 0; chunk < chunks; ++chunk) function(context, chunk, 0);
}

}  // namespace scree
