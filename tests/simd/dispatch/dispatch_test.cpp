// Laws of dispatch: a forced instruction set is really the one whose code runs.
#include <dlfcn.h>
#include <elf.h>
#include <gtest/gtest.h>
#include <simd/dispatch/kernels.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace scree::simd {
namespace {

constexpr InstructionSet kSets[] = {InstructionSet::scalar, InstructionSet::sse2, InstructionSet::avx2,
                                    InstructionSet::avx512};
constexpr const char* kNames[] = {"scalar", "sse2", "avx2", "avx512"};
constexpr int kLanesOf[] = {1, 4, 8, 16};

// The functions of a table, family by family. A family is a struct of function pointers, after `data` bytes.
template <class Family>
void append(const Family& family, std::size_t data, std::vector<const void*>& functions) {
  static_assert(sizeof(Family) % sizeof(void*) == 0);
  const std::size_t first = functions.size();
  functions.resize(first + (sizeof(Family) - data) / sizeof(void*));
  std::memcpy(functions.data() + first, reinterpret_cast<const char*>(&family) + data, sizeof(Family) - data);
}

std::vector<const void*> functions_of(const Kernels& kernels) {
  std::vector<const void*> functions;
  append(kernels.body, 0, functions);
  append(kernels.pair, 0, functions);
  append(kernels.collide, 0, functions);
  append(kernels.contact, sizeof(kernels.contact.block_bytes), functions);
  for (const JointVariantKernels& joint : kernels.joint.variant) {
    append(joint, offsetof(JointVariantKernels, prepare), functions);
  }
  return functions;
}

// Names of the functions of the program or shared library that holds an address, from its symbol table
// (System V ABI, chapter 4). dladdr() alone knows exported symbols only.
class Symbols {
 public:
  explicit Symbols(const void* address) {
    Dl_info info{};
    if (dladdr(address, &info) == 0) return;
    std::ifstream file(info.dli_fname, std::ios::binary);
    if (!file) file.open("/proc/self/exe", std::ios::binary);
    const std::vector<char> image{std::istreambuf_iterator<char>(file), {}};
    const auto header = read<Elf64_Ehdr>(image, 0);
    if (image.size() < sizeof(Elf64_Ehdr) || header.e_ident[EI_CLASS] != ELFCLASS64) return;
    const std::uint64_t base = header.e_type == ET_DYN ? reinterpret_cast<std::uintptr_t>(info.dli_fbase) : 0;
    for (std::uint64_t i = 0; i < header.e_shnum; ++i) {
      const auto section = read<Elf64_Shdr>(image, header.e_shoff + i * sizeof(Elf64_Shdr));
      if (section.sh_type != SHT_SYMTAB) continue;
      const auto names = read<Elf64_Shdr>(image, header.e_shoff + section.sh_link * sizeof(Elf64_Shdr));
      for (std::uint64_t at = 0; at < section.sh_size; at += sizeof(Elf64_Sym)) {
        const auto symbol = read<Elf64_Sym>(image, section.sh_offset + at);
        if (ELF64_ST_TYPE(symbol.st_info) != STT_FUNC) continue;
        names_[base + symbol.st_value].insert(image.data() + names.sh_offset + symbol.st_name);
      }
    }
  }

  bool empty() const { return names_.empty(); }

  // Names of the function that begins at an address.
  std::set<std::string> at(const void* address) const {
    const auto found = names_.find(reinterpret_cast<std::uintptr_t>(address));
    return found != names_.end() ? found->second : std::set<std::string>{};
  }

 private:
  template <class T>
  static T read(const std::vector<char>& image, std::uint64_t at) {
    T result{};
    if (at + sizeof(T) <= image.size()) std::memcpy(&result, image.data() + at, sizeof(T));
    return result;
  }
  std::map<std::uint64_t, std::set<std::string>> names_;
};

TEST(Dispatch, ATableBelongsToTheRequestedSet) {
  for (const InstructionSet set : kSets) {
    const Kernels* kernels = find_kernels(set);
    if (kernels == nullptr) continue;
    EXPECT_EQ(kernels->instruction_set, set);
    EXPECT_STREQ(kernels->name, kNames[static_cast<int>(set)]);
    EXPECT_EQ(kernels->lanes, kLanesOf[static_cast<int>(set)]);
    EXPECT_EQ(find_kernels(set), kernels) << "a table stays where it is";
  }
}

TEST(Dispatch, TheScalarSetIsAlwaysSupportedAndTheWidestIsTheLastSupported) {
  ASSERT_NE(find_kernels(InstructionSet::scalar), nullptr);
  const Kernels* widest = nullptr;
  for (const InstructionSet set : kSets) {
    if (const Kernels* kernels = find_kernels(set)) widest = kernels;
  }
  EXPECT_EQ(&widest_kernels(), widest);
  EXPECT_EQ(find_kernels(static_cast<InstructionSet>(kInstructionSetCount)), nullptr);
}

TEST(Dispatch, NoFunctionIsMissingAndNoneServesTwoSets) {
  std::map<const void*, const char*> owners;
  for (const InstructionSet set : kSets) {
    const Kernels* kernels = find_kernels(set);
    if (kernels == nullptr) continue;
    for (const void* function : functions_of(*kernels)) {
      ASSERT_NE(function, nullptr) << kernels->name;
      const auto [owner, is_new] = owners.emplace(function, kernels->name);
      EXPECT_STREQ(owner->second, kernels->name) << "shared with another instruction set";
    }
  }
}

TEST(Dispatch, EveryFunctionLiesInTheCodeOfItsOwnSet) {
  for (const InstructionSet set : kSets) {
    const Kernels* kernels = find_kernels(set);
    if (kernels == nullptr) continue;
    const std::vector<const void*> functions = functions_of(*kernels);
    if (functions.empty()) continue;
    const Symbols symbols(functions[0]);
    ASSERT_FALSE(symbols.empty()) << "the program is stripped of its symbols";
    const std::string name = kernels->name;
    const std::string mangled = "5scree4simd" + std::to_string(name.size()) + name;  // scree::simd::<name>
    for (std::size_t i = 0; i < functions.size(); ++i) {
      const std::set<std::string> found = symbols.at(functions[i]);
      ASSERT_FALSE(found.empty()) << name << ", function " << i;
      for (const std::string& symbol : found) EXPECT_NE(symbol.find(mangled), std::string::npos) << symbol;
    }
  }
}

TEST(Dispatch, TheSymbolTableIsReadCorrectly) {
  const auto* address = reinterpret_cast<const void*>(&find_kernels);
  const Symbols symbols(address);
  ASSERT_FALSE(symbols.empty()) << "the program is stripped of its symbols";
  const std::set<std::string> names = symbols.at(address);
  ASSERT_FALSE(names.empty());
  EXPECT_NE(names.begin()->find("5scree4simd12find_kernels"), std::string::npos) << *names.begin();
}

}  // namespace
}  // namespace scree::simd
