// See agree.h.
#include <parallel/distributed/agree.h>
#include <parallel/distributed/messages.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

constexpr std::size_t kMostText = 1000;  // of what ranks say

// Each text once, with the rank that says it first; of all ranks' one, without that.
std::string join_texts(const std::vector<std::pair<int, std::string>>& told, int ranks) {
  std::string all;
  std::vector<std::string> known;
  for (const auto& [rank, text] : told) {
    if (std::find(known.begin(), known.end(), text) != known.end()) continue;
    known.push_back(text);
    all += (all.empty() ? "rank " : "; rank ") + std::to_string(rank) + ": " + text;
  }
  if (known.size() == 1 && std::cmp_equal(told.size(), ranks)) all = known.front();
  all.resize(std::min(all.size(), kMostText));
  return all;
}

}  // namespace

std::optional<Error> agree(Transport& transport, const std::optional<Error>& problem) {
  std::int64_t failures = problem ? 1 : 0;
  transport.add_up({&failures, 1});
  if (failures == 0) return {};
  std::vector<std::pair<int, std::string>> texts;
  std::optional<ErrorCode> code;
  const int here = transport.rank(), ranks = transport.ranks();
  const std::string own = problem ? problem->what() : "";
  const std::int32_t own_code = problem ? static_cast<std::int32_t>(problem->code()) : -1;
  const std::vector<std::int32_t> codes = gather_rows(transport, own_code);
  for (int to = 0; to < ranks; ++to) {
    if (to != here) send_list<char>(transport, to, std::span(own.data(), own.size()));
  }
  for (int from = 0; from < ranks; ++from) {
    std::string text = own;
    if (from != here) {
      const std::vector<char> told = receive_list<char>(transport, from);
      text.assign(told.begin(), told.end());
    }
    const std::int32_t of_rank = codes[static_cast<std::size_t>(from)];
    if (of_rank < 0) continue;
    if (!code) code = static_cast<ErrorCode>(of_rank);
    texts.emplace_back(from, std::move(text));
  }
  return Error(join_texts(texts, ranks), code.value_or(ErrorCode::io_failure));
}

std::string tell_all(Transport& transport, const std::string& text) {
  if (transport.rank() != 0) {
    const std::vector<char> told = receive_list<char>(transport, 0);
    return {told.begin(), told.end()};
  }
  for (int to = 1; to < transport.ranks(); ++to)
    send_list<char>(transport, to, std::span(text.data(), text.size()));
  return text;
}

std::optional<Error> tell_all(Transport& transport, const std::optional<Error>& problem) {
  std::int64_t told[2] = {0, 0};  // whether there is one, and its code
  if (transport.rank() == 0 && problem) {
    told[0] = 1;
    told[1] = static_cast<std::int64_t>(problem->code());
  }
  transport.add_up(told);
  if (told[0] == 0) return {};
  return Error(tell_all(transport, std::string(problem ? problem->what() : "")),
               static_cast<ErrorCode>(told[1]));
}

}  // namespace scree
