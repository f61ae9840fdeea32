// Writing, reading and making the calls of the table; see call_bytes.h.
#include <core/geometry/hull/hull_build.h>
#include <core/state/recording_format/call_bytes.h>
#include <core/state/recording_format/value_bytes.h>

#include <tuple>
#include <type_traits>
#include <utility>

namespace scree {

namespace {

// How arguments are kept while they are read.
template <class Argument>
struct Kept {
  using Type = Argument;
};
template <class Item>
struct Kept<std::span<const Item>> {
  using Type = std::vector<Item>;
};

template <class Types>
struct Arguments;
template <class... Types>
struct Arguments<std::tuple<Types...>> {
  using References = std::tuple<const Types&...>;
  using Values = std::tuple<typename Kept<Types>::Type...>;
};
template <RecordedCall kCall>
using ArgumentsOf = Arguments<typename CallArguments<kCall>::Types>;

// Room for what a list of definitions makes, which is a call's first or second argument.
std::vector<BodyId> ids_for(const std::vector<BodyDef>& defs, const auto&...) {
  return std::vector<BodyId>(defs.size());
}
std::vector<JointId> ids_for(const std::vector<JointDef>& defs, const auto&...) {
  return std::vector<JointId>(defs.size());
}
std::vector<ShapeId> ids_for(BodyId, const std::vector<ShapeDef>& defs) {
  return std::vector<ShapeId>(defs.size());
}

template <class Values>
Values read_arguments(CallReader& reader) {
  Values values;
  std::apply([&reader](auto&... value) { (read_value(reader, value), ...); }, values);
  return values;
}

}  // namespace

const char* name_of(RecordedCall call) {
#define SCREE_CALL_NAME(name, function, ...) #name,
  constexpr const char* kNames[] = {"step", SCREE_RECORDED_CALLS(SCREE_CALL_NAME)};
#undef SCREE_CALL_NAME
  return call < RecordedCall::count ? kNames[static_cast<std::size_t>(call)] : "no call";
}

template <RecordedCall kCall>
void write_arguments(const void* arguments, CallWriter& writer) {
  using References = typename ArgumentsOf<kCall>::References;
  std::apply([&writer](const auto&... argument) { (write_value(writer, argument), ...); },
             *static_cast<const References*>(arguments));
}
#define SCREE_INSTANTIATE_CALL(call, function, ...) \
  template void write_arguments<RecordedCall::call>(const void*, CallWriter&);
SCREE_RECORDED_CALLS(SCREE_INSTANTIATE_CALL)
#undef SCREE_INSTANTIATE_CALL

void CallWriter::put_hull(const Hull& hull) { put(solids_.number_of(HullAccess::solid(hull))); }
void CallWriter::put_mesh(const TriangleMesh& mesh) { put(solids_.number_of(MeshAccess::solid(mesh))); }

namespace {

// The solid of the number that follows.
template <class Pointer>
const Pointer& take_solid(CallReader& reader, std::span<const Pointer> known, const char* what) {
  const std::size_t offset = reader.at();
  const auto number = reader.take<std::int32_t>();
  if (number < 0 || std::cmp_greater_equal(number, known.size()))
    refuse_bytes(offset, std::string("there is no ") + what + " " + std::to_string(number) + " so far");
  return known[static_cast<std::size_t>(number)];
}

}  // namespace

Hull CallReader::take_hull() {
  if (solids_) return HullAccess::hull(take_solid(*this, solids_->hulls, "hull"));
  take<std::int32_t>();
  return {};
}

TriangleMesh CallReader::take_mesh() {
  if (solids_) return MeshAccess::mesh(take_solid(*this, solids_->meshes, "mesh"));
  take<std::int32_t>();
  return {};
}

void write_call(const MadeCall& call, CallWriter& writer) {
  write_value(writer, call.call);
  call.write(call.arguments, writer);
}

void take_call(RecordedCall call, CallReader& reader, World* world) {
  switch (call) {
#define SCREE_TAKE_CALL(name, function, ...)                                             \
  case RecordedCall::name: {                                                             \
    const auto values = read_arguments<ArgumentsOf<RecordedCall::name>::Values>(reader); \
    if (world == nullptr) return;                                                        \
    std::apply(                                                                          \
        [world](const auto& first, const auto&... rest) {                                \
          if constexpr (requires { world->function(first, rest...); }) {                 \
            static_cast<void>(world->function(first, rest...));                          \
          } else {                                                                       \
            auto ids = ids_for(first, rest...);                                          \
            world->function(first, rest..., ids);                                        \
          }                                                                              \
        },                                                                               \
        values);                                                                         \
    return;                                                                              \
  }
    SCREE_RECORDED_CALLS(SCREE_TAKE_CALL)
#undef SCREE_TAKE_CALL
    case RecordedCall::step:
    case RecordedCall::count:
      break;
  }
  refuse_bytes(reader.at(), "there is no call " + std::to_string(static_cast<int>(call)));
}

}  // namespace scree
