// Figures of recordings -> tables and JSON; see replay.h.
#include <tools/command/replay.h>
#include <tools/command/text.h>

#include <nlohmann/json.hpp>

namespace scree::command {
namespace {

using Json = nlohmann::ordered_json;

// A writer's name may hold any bytes, and so may a file's.
std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string span_of(std::uint64_t from, std::uint64_t to) { return grouped(from) + " to " + grouped(to); }

// The differences of the states where they were compared.
std::string describe_state(const Divergence& divergence) {
  if (divergence.difference.empty()) {
    return divergence.compared_at == 0 ? "no state to compare it with"
                                       : "the states at step " + grouped(divergence.compared_at) + " agree";
  }
  return (divergence.compared_at == 0 ? std::string() : "at step " + grouped(divergence.compared_at) + ": ") +
         divergence.difference;
}

Json to_json(const Divergence& divergence, const char* expected, const char* actual) {
  Json json;
  json["step"] = divergence.step;
  json[expected] = hash_digits(divergence.expected_hash);
  json[actual] = hash_digits(divergence.actual_hash);
  json["compared_at"] = divergence.compared_at;
  json["difference"] = divergence.difference;
  return json;
}

}  // namespace

std::string to_table(const ReplayFigures& figures) {
  std::string table = figures.file + "\n";
  table += row("steps", span_of(figures.from, figures.to) + ", " + grouped(figures.steps) + " played");
  if (figures.verified) {
    table += row("ms per step", format("%.3f mean, with the comparisons", figures.ms_mean));
  } else {
    table += row("ms per step", format("%.3f mean, %.3f median, %.3f min, %.3f max", figures.ms_mean,
                                       figures.ms_median, figures.ms_min, figures.ms_max));
  }
  if (figures.trace) table += trace_row(*figures.trace);
  table += row("instruction set", isa_name(figures.isa));
  if (figures.ranks > 0) table += row("ranks", std::to_string(figures.ranks));
  table += row("threads", std::to_string(figures.threads));
  table += row("hash", hash_digits(figures.hash));
  if (figures.divergence) {
    const Divergence& divergence = *figures.divergence;
    table += row("DIFFERENT", "first in step " + grouped(divergence.step) + ": hash " +
                                  hash_digits(divergence.actual_hash) + " instead of " +
                                  hash_digits(divergence.expected_hash));
    table += row("", describe_state(divergence));
  } else if (figures.verified) {
    table += row("verified", "all " + grouped(figures.steps) + " hashes and " + grouped(figures.keyframes) +
                                 (figures.keyframes == 1 ? " keyframe agree" : " keyframes agree"));
  } else if (figures.recorded_hash) {
    table +=
        row("recorded hash", *figures.recorded_hash == figures.hash
                                 ? "the same"
                                 : hash_digits(*figures.recorded_hash) + ", DIFFERENT: --verify tells where");
  }
  return table;
}

std::string to_json(const ReplayFigures& figures) {
  Json json;
  json["file"] = figures.file;
  json["isa"] = isa_name(figures.isa);
  json["threads"] = figures.threads;
  if (figures.ranks > 0) json["ranks"] = figures.ranks;
  json["from"] = figures.from;
  json["to"] = figures.to;
  json["steps"] = figures.steps;
  json["ms_per_step"]["mean"] = figures.ms_mean;
  if (!figures.verified) {
    json["ms_per_step"]["median"] = figures.ms_median;
    json["ms_per_step"]["min"] = figures.ms_min;
    json["ms_per_step"]["max"] = figures.ms_max;
  }
  json["hash"] = hash_digits(figures.hash);
  json["recorded_hash"] = figures.recorded_hash ? Json(hash_digits(*figures.recorded_hash)) : Json();
  json["verified"] = figures.verified && !figures.divergence;
  json["keyframes"] = figures.keyframes;
  if (const auto& trace = figures.trace) {
    json["trace"] = {{"file", trace->file}, {"zones", trace->zones}, {"left_out", trace->left_out}};
  }
  json["divergence"] =
      figures.divergence ? to_json(*figures.divergence, "expected_hash", "actual_hash") : Json();
  return text_of(json);
}

std::string to_table(const InfoFigures& figures) {
  const RecordingInfo& info = figures.info;
  const std::uint64_t steps = info.last_step - info.first_step;
  std::string table = figures.file + "\n";
  table += row("format", "version " + std::to_string(info.version));
  table += row("written by", printable(info.writer));
  table += row("finished", info.finished ? "yes" : "no: the recorder did not come to the end");
  table += row("steps", span_of(info.first_step, info.last_step));
  table += row("calls", grouped(info.calls));
  table += row("keyframes", grouped(info.keyframes));
  table += row("hulls", grouped(info.hulls));
  table += row("meshes", grouped(info.meshes));
  const auto counts = [](std::uint64_t bodies, std::uint64_t shapes) {
    return grouped(bodies) + " bodies, " + grouped(shapes) + " shapes";
  };
  table += row("first state", counts(figures.first_bodies, figures.first_shapes));
  table += row("last keyframe", counts(figures.last_bodies, figures.last_shapes));
  table +=
      row("file", grouped(info.file_bytes) + " bytes of " + grouped(info.raw_bytes) + " before compression");
  if (steps > 0) {
    table += row("bytes per step",
                 format("%.1f", static_cast<double>(info.file_bytes) / static_cast<double>(steps)));
  }
  if (info.lost_bytes > 0) {
    table +=
        row("lost", grouped(info.lost_bytes) + " bytes at the end, of a chunk that was not written whole");
  }
  return table;
}

std::string to_json(const InfoFigures& figures) {
  const RecordingInfo& info = figures.info;
  Json json;
  json["file"] = figures.file;
  json["version"] = info.version;
  json["writer"] = info.writer;
  json["finished"] = info.finished;
  json["first_step"] = info.first_step;
  json["last_step"] = info.last_step;
  json["calls"] = info.calls;
  json["keyframes"] = info.keyframes;
  json["keyframe_steps"] = figures.keyframe_steps;
  json["hulls"] = info.hulls;
  json["meshes"] = info.meshes;
  json["first_state"] = {{"bodies", figures.first_bodies}, {"shapes", figures.first_shapes}};
  json["last_keyframe"] = {{"bodies", figures.last_bodies}, {"shapes", figures.last_shapes}};
  json["file_bytes"] = info.file_bytes;
  json["raw_bytes"] = info.raw_bytes;
  json["lost_bytes"] = info.lost_bytes;
  return text_of(json);
}

std::string to_table(const DiffFigures& figures) {
  std::string table;
  table += row("a", figures.a + ", steps " + span_of(figures.first_a, figures.last_a));
  table += row("b", figures.b + ", steps " + span_of(figures.first_b, figures.last_b));
  if (!figures.divergence) {
    table += row("same", "in all steps that both have, " + span_of(figures.from(), figures.to()));
    return table;
  }
  const Divergence& divergence = *figures.divergence;
  table += row("PARTED", "first in step " + grouped(divergence.step) + ": hash " +
                             hash_digits(divergence.expected_hash) + " in a, " +
                             hash_digits(divergence.actual_hash) + " in b");
  table += row("", describe_state(divergence));
  return table;
}

std::string to_json(const DiffFigures& figures) {
  Json json;
  json["a"] = {{"file", figures.a}, {"first_step", figures.first_a}, {"last_step", figures.last_a}};
  json["b"] = {{"file", figures.b}, {"first_step", figures.first_b}, {"last_step", figures.last_b}};
  json["from"] = figures.from();
  json["to"] = figures.to();
  json["same"] = !figures.divergence;
  json["divergence"] = figures.divergence ? to_json(*figures.divergence, "hash_a", "hash_b") : Json();
  return text_of(json);
}

}  // namespace scree::command
