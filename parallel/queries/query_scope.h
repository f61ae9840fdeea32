// The scope of a query: the world, where its shapes are found, and which of them the query looks at.
#pragma once

#include <core/world/check.h>
#include <core/world/fp_environment.h>
#include <parallel/queries/query_index.h>
#include <parallel/queries/query_solid.h>
#include <scree/queries.h>
#include <simd/dispatch/kernels.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <vector>

namespace scree::queries {

struct Scope {
  const WorldData& data;
  const QueryIndex& index;
  const simd::Kernels& kernels;
  const QueryOptions& options;
  const bool takes_all;  // every shape passes: it need not be looked up

  Scope(const WorldData& world_data, const simd::Kernels& chosen, const QueryOptions& given);
};

// Names of calls in errors. Items are those of a query of many.
constexpr Call call_of(const char* name, const char* items = "query") { return {name, -1, "", items}; }

void check_options(Call call, const WorldData& data, const QueryOptions& options);
// Of lists that must have as many entries as there are queries.
void check_length(Call call, const char* what, std::size_t length, std::size_t queries);

void check_point(Call call, const char* what, Vec3 point);
void check_translation(Call call, Vec3 translation);
void check_placed(Call call, const Geometry& geometry, const Pose& pose);

// A box about the solid, rounded outward by more than the trees' boxes may be off.
simd::MeetTask task_of(const Solid& solid);
// The solid's box on its way, or a ray if it has no extent.
simd::CrossTask task_of(const Solid& solid, Vec3 translation);

// Those of single queries.
const simd::Kernels& query_kernels();

// A scope for a query on the calling thread, whose floating-point environment is ours meanwhile.
struct OwnScope {
  FpEnvironment environment{};
  Scope scope;

  // Throws for a world that was moved from and for options that are wrong.
  OwnScope(Call call, const World& world, const QueryOptions& options);
};

// The rule of Filter.
bool agree(const Filter& a, const Filter& b);

// Whether the query looks at the shape.
bool passes(const Scope& scope, std::int32_t shape);

// Walks through all trees with a kernel and asks ask(shape, limit), which returns the new limit, of the
// shapes that pass. Returns the last limit. Kernels cannot pass on exceptions, so these wait until the end.
template <class Task, class Ask>
float walk(const Scope& scope,
           float (*kernel)(const simd::TreeView&, const Task&, float, simd::AskShape, void*),
           const Task& task, float limit, Ask&& ask) {
  struct Asking {
    const Scope& scope;
    std::remove_reference_t<Ask>& ask;
    bool is_base;
    std::exception_ptr thrown;
  };
  Asking asking{scope, ask, true, nullptr};
  const simd::AskShape ask_shape = [](void* context, std::int32_t shape, float now) -> float {
    Asking& self = *static_cast<Asking*>(context);
    if (self.is_base && self.scope.index.is_loose[shape] != 0) return now;
    try {
      return passes(self.scope, shape) ? self.ask(shape, now) : now;
    } catch (...) {
      self.thrown = std::current_exception();
      return -1.0f;
    }
  };
  const auto through = [&](const simd::TreeView& tree) {
    if (limit >= 0.0f) limit = kernel(tree, task, limit, ask_shape, &asking);
  };
  for_each_base_tree(scope.data, scope.index, through);
  asking.is_base = false;
  for_each_loose_tree(scope.data, scope.index, through);
  if (asking.thrown != nullptr) std::rethrow_exception(asking.thrown);
  return limit;
}

// The smallest limit that is not below the number, or little more.
inline float limit_of(double value) {
  constexpr double kRoundedUp = 1.0 + 2e-7;
  return static_cast<float>(value * kRoundedUp);
}

constexpr int kQueriesPerChunk = 32;  // 10 to 100 microseconds

// Queries of many in the order in which they were given.
struct AsGiven {
  std::vector<std::int32_t> operator()(const Scope&, Crew&) const { return {}; }
};

// Runs ask(scope, i) for all queries of many, on all threads, in the order that arrange(scope, crew) returns.
template <class Ask, class Arrange = AsGiven>
void ask_all(Call call, const World& world, std::size_t queries, Workers& workers,
             const QueryOptions& options, Ask&& ask, const Arrange& arrange = {}) {
  const WorldData& data = internals(world, call.name);
  check_options(call, data, options);
  check_room(call, "queries", 0, queries);
  if (queries == 0) return;
  Crew crew(workers);
  const Scope scope(data, crew.kernels(), options);
  const std::vector<std::int32_t> order = arrange(scope, crew);
  crew.run_ranges(static_cast<int>(queries), kQueriesPerChunk, [&](int begin, int end, int) {
    for (int i = begin; i < end; ++i)
      ask(scope, static_cast<std::size_t>(order.empty() ? i : order[static_cast<std::size_t>(i)]));
  });
}

// The same for queries that have any number of answers: list(scope, i, answers) adds those of query i.
template <class Answer, class List>
AnswerLists<Answer> list_all(Call call, const World& world, std::size_t queries, Workers& workers,
                             const QueryOptions& options, List&& list) {
  AnswerLists<Answer> all;
  all.begins.assign(queries + 1, 0);
  std::vector<std::vector<Answer>> by_chunk((queries + kQueriesPerChunk - 1) / kQueriesPerChunk);
  // A chunk's queries are asked in their order by one thread.
  ask_all(call, world, queries, workers, options, [&](const Scope& scope, std::size_t i) {
    std::vector<Answer>& answers = by_chunk[i / kQueriesPerChunk];
    const std::size_t before = answers.size();
    list(scope, i, answers);
    all.begins[i + 1] = answers.size() - before;
  });
  for (std::size_t i = 0; i < queries; ++i) all.begins[i + 1] += all.begins[i];
  all.answers.reserve(all.begins.back());
  for (const std::vector<Answer>& answers : by_chunk) {
    all.answers.insert(all.answers.end(), answers.begin(), answers.end());
  }
  return all;
}

}  // namespace scree::queries
