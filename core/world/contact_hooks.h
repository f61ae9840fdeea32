// Answers of hooks: what is sound, and where those that were given for the next step stand.
#pragma once

#include <core/world/pair_key.h>
#include <core/world/world_data.h>

#include <algorithm>

namespace scree {

// Within the ranges of scree/contact_hooks.h.
bool is_sound(const ContactRules& rules);
ContactRules rules_of(const HookAnswer& answer);

inline std::uint64_t key_of(const HookAnswer& answer) {
  return pair_key(answer.shape_a.index, answer.shape_b.index);
}

// The first of the answers about the pair, or where it would stand.
inline const HookAnswer* first_answer(const Hooks& hooks, const ShapePair& pair) {
  return std::lower_bound(hooks.answers.begin(), hooks.answers.end(), key_of(pair),
                          [](const HookAnswer& answer, std::uint64_t key) { return key_of(answer) < key; });
}

// Whether hooks have taken the pair out of this step.
inline bool is_refused(const Hooks& hooks, const ShapePair& pair) {
  if (hooks.refused.empty()) return false;
  return std::binary_search(hooks.refused.begin(), hooks.refused.end(), pair, comes_before);
}

}  // namespace scree
