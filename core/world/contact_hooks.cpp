// The calls of World about hooks of contacts: which shapes ask, the functions, and answers without them.
#include <core/state/recording_format/recorded_calls.h>
#include <core/world/check.h>
#include <core/world/contact_hooks.h>
#include <core/world/edit.h>
#include <core/world/fp_environment.h>

#include <string>
#include <tuple>
#include <utility>

namespace scree {

namespace {

constexpr float kMaxBeltSpeed = 2.0f * kMaxSurfaceSpeed;  // of one surface against another

auto place_of(const ContactAnswer& answer) {
  return std::tuple(answer.shape_a.index, answer.shape_b.index, answer.contact);
}

void check_rules(Call call, const ContactRules& rules) {
  check_range(call, "friction", rules.friction, 0.0f, kMaxFriction);
  check_range(call, "restitution", rules.restitution, 0.0f, 1.0f);
  check_range(call, "rolling_resistance", rules.rolling_resistance, 0.0f, kMaxRollingResistance);
  check_vector(call, "surface_velocity", rules.surface_velocity, kMaxBeltSpeed);
}

void check_answer(Call call, const WorldData& data, const ContactAnswer& answer) {
  const std::int32_t a = checked_row(call, data, answer.shape_a);
  const std::int32_t b = checked_row(call, data, answer.shape_b);
  if (a >= b) {
    fail(call, "shape_a has the index " + std::to_string(a) + ", which must be below shape_b's, " +
                   std::to_string(b));
  }
  if (answer.contact < -1) {
    fail(call, "contact is " + std::to_string(answer.contact) + "; it must be -1 or more");
  }
  if (answer.contact >= 0) check_rules(call, answer.rules);
}

HookAnswer row_of(const ContactAnswer& answer) {
  const ContactRules& rules = answer.rules;
  const bool is_refusal = answer.contact < 0;
  HookAnswer row{{answer.shape_a.index, answer.shape_a.generation},
                 {answer.shape_b.index, answer.shape_b.generation},
                 answer.contact,
                 !is_refusal && rules.acts ? 1u : 0u,
                 is_refusal ? 0.0f : rules.friction,
                 is_refusal ? 0.0f : rules.restitution,
                 is_refusal ? 0.0f : rules.rolling_resistance,
                 {}};
  store(row.surface_velocity, is_refusal ? Vec3{} : rules.surface_velocity);
  return row;
}

}  // namespace

bool is_sound(const ContactRules& rules) {
  const auto within = [](float value, float low, float high) { return value >= low && value <= high; };
  const Vec3 v = rules.surface_velocity;
  return within(rules.friction, 0.0f, kMaxFriction) && within(rules.restitution, 0.0f, 1.0f) &&
         within(rules.rolling_resistance, 0.0f, kMaxRollingResistance) &&
         within(v.x, -kMaxBeltSpeed, kMaxBeltSpeed) && within(v.y, -kMaxBeltSpeed, kMaxBeltSpeed) &&
         within(v.z, -kMaxBeltSpeed, kMaxBeltSpeed);
}

ContactRules rules_of(const HookAnswer& answer) {
  return {answer.acts != 0, answer.friction, answer.restitution, answer.rolling_resistance,
          to_vec3(answer.surface_velocity)};
}

ContactHooks World::contact_hooks(ShapeId shape) const {
  constexpr Call call{"contact_hooks"};
  const WorldData& data = opened(call, data_);
  return data.shapes.hooks[checked_row(call, data, shape)];
}

void World::set_contact_hooks(ShapeId shape, ContactHooks hooks) {
  constexpr Call call{"set_contact_hooks"};
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::set_contact_hooks> call_record(data, shape, hooks);
  const std::int32_t row = checked_row(call, data, shape);
  check_hooks(call, hooks);
  data.shapes.hooked +=
      (hooks != ContactHooks::none ? 1 : 0) - (data.shapes.hooks[row] != ContactHooks::none ? 1 : 0);
  data.shapes.hooks[row] = hooks;
}

void World::set_contact_filter(ContactFilter filter) {
  opened({"set_contact_filter"}, data_).hooks.filter = std::move(filter);
}

bool World::has_contact_filter() const noexcept { return data_ != nullptr && data_->hooks.filter != nullptr; }

void World::set_contact_rule(ContactRule rule) {
  opened({"set_contact_rule"}, data_).hooks.rule = std::move(rule);
}

bool World::has_contact_rule() const noexcept { return data_ != nullptr && data_->hooks.rule != nullptr; }

void World::answer_contact_hooks(std::span<const ContactAnswer> answers) {
  constexpr Call call{"answer_contact_hooks", -1, "World::", "answer"};
  const FpEnvironment environment;
  WorldData& data = opened(call, data_);
  const CallRecord<RecordedCall::answer_contact_hooks> call_record(data, answers);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const Call here = item_of(call, answers.size(), i);
    check_answer(here, data, answers[i]);
    if (i > 0 && place_of(answers[i - 1]) >= place_of(answers[i])) {
      fail(here, "it must come before the answer ahead of it: they ascend by shape_a, shape_b and contact");
    }
  }
  Column<HookAnswer>& rows = data.hooks.answers;
  rows.reserve(answers.size());
  rows.clear();
  for (const ContactAnswer& answer : answers) rows.push_back(row_of(answer));
}

}  // namespace scree
