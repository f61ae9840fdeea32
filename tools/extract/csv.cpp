// Tables of text, in the form of RFC 4180 with bare line feeds. Numbers are the shortest that read back as
// they were; what is no number is left empty.
#include <scree/error.h>
#include <tools/extract/tables.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

namespace scree::extract {
namespace {

template <class Number>
void put(Number number, std::string& text) {
  char digits[40];
  const auto [end, problem] = std::to_chars(digits, digits + sizeof digits, number);
  text.append(digits, end);
}

void put_value(const Values& values, std::size_t i, std::string& text) {
  text += ',';
  if (std::isnan(values[i])) return;
  if (values.is_wide) {
    put(values.wide[i], text);
  } else {
    put(values.single[i], text);
  }
}

void put_index(std::int64_t index, std::string& text) {
  text += ',';
  if (index != EventRow::kNone) put(index, text);
}

std::string event_table(const Extract& extract) {
  std::string text = "step,time,event,body_a,body_b,shape_a,shape_b,joint,value\n";
  for (const EventRow& event : extract.events) {
    put(event.step, text);
    text += ',';
    put(event.time, text);
    text += ',';
    text += name_of(event.kind);
    for (const std::int64_t index : {event.body_a, event.body_b, event.shape_a, event.shape_b, event.joint})
      put_index(index, text);
    text += ',';
    put(event.value, text);
    text += '\n';
  }
  return text;
}

std::string head_of(const Extract& extract, Owner owner) {
  std::string text = "step,time";
  if (owner != Owner::world) text += owner == Owner::body ? ",body" : ",joint";
  for (const Signal signal : extract.wanted.signals) {
    const SignalInfo& info = info_of(signal);
    for (const char* component : components_of(info)) text += std::string(",") + info.name + component;
  }
  return text + "\n";
}

}  // namespace

void check_fits_csv(const Wanted& wanted) {
  constexpr const char* kOwners[] = {"bodies", "joints", "the world"};
  std::string kinds;
  int count = 0;
  for (const Owner owner : {Owner::body, Owner::joint, Owner::world}) {
    if (!wanted.has(owner)) continue;
    const auto first = std::find_if(wanted.signals.begin(), wanted.signals.end(),
                                    [owner](Signal signal) { return info_of(signal).owner == owner; });
    if (count++ > 0) kinds += ", ";
    kinds += info_of(*first).name;
    kinds += " (of ";
    kinds += kOwners[static_cast<int>(owner)];
    kinds += ")";
  }
  if (wanted.events) kinds += count++ > 0 ? ", events" : "events";
  if (count > 1) {
    throw Error("--signal: " + kinds +
                " do not fit into one table; write an .npz file, or a .csv file for each");
  }
}

std::string to_csv(const Extract& extract) {
  check_fits_csv(extract.wanted);
  if (extract.wanted.events) return event_table(extract);
  const Owner owner = info_of(extract.wanted.signals.front()).owner;
  const std::vector<std::uint32_t>& rows = owner == Owner::body ? extract.bodies : extract.joints;
  const std::size_t count = extract.rows_of(owner);
  std::string text = head_of(extract, owner);
  for (std::size_t sample = 0; sample < extract.steps.size(); ++sample) {
    for (std::size_t row = 0; row < count; ++row) {
      put(extract.steps[sample], text);
      text += ',';
      put(extract.times[sample], text);
      if (owner != Owner::world) put_index(rows[row], text);
      for (const Signal signal : extract.wanted.signals) {
        const auto width = static_cast<std::size_t>(info_of(signal).width);
        for (std::size_t k = 0; k < width; ++k)
          put_value(extract.values[static_cast<std::size_t>(signal)], (sample * count + row) * width + k,
                    text);
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace scree::extract
