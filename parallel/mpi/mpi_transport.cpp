// See scree/mpi.h. Sends are begun at once and kept until MPI has taken them; a message's length comes with
// it.
#include <scree/error.h>
#include <scree/mpi.h>

#include <algorithm>
#include <deque>
#include <exception>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

// Of a message, or of its last part; of parts before it. MPI counts the bytes of one by an int.
constexpr int kTag = 1, kTagOfMore = 2;
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

void check(int result, const char* what, ErrorCode code = ErrorCode::invalid_value) {
  if (result == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = {};
  int length = 0;
  MPI_Error_string(result, text, &length);
  throw Error(
      std::string("MpiTransport: ") + what + ": " + std::string(text, static_cast<std::size_t>(length)),
      code);
}

}  // namespace

struct MpiTransport::Impl {
  // A message on its way.
  struct Sending {
    std::vector<std::byte> bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  MPI_Comm communicator = MPI_COMM_NULL;
  int rank = 0, ranks = 1;
  int exceptions = std::uncaught_exceptions();  // when this was made
  std::deque<Sending> sendings;
  std::vector<std::byte> received;  // the last message

  // Forgets the messages that have left, in the order in which they were sent.
  void drop_sent() {
    while (!sendings.empty()) {
      int has_left = 0;
      check(MPI_Test(&sendings.front().request, &has_left, MPI_STATUS_IGNORE), "send");
      if (has_left == 0) return;
      sendings.pop_front();
    }
  }
};

MpiTransport::MpiTransport(MPI_Comm communicator) : impl_(std::make_unique<Impl>()) {
  check(MPI_Comm_dup(communicator, &impl_->communicator), "MPI_Comm_dup");
  MPI_Comm_set_errhandler(impl_->communicator, MPI_ERRORS_RETURN);
  check(MPI_Comm_rank(impl_->communicator, &impl_->rank), "MPI_Comm_rank");
  check(MPI_Comm_size(impl_->communicator, &impl_->ranks), "MPI_Comm_size");
}

MpiTransport::~MpiTransport() {
  // What is on its way to a rank that waits for this one would never leave: MPI_Abort comes next.
  if (std::uncaught_exceptions() > impl_->exceptions) {
    impl_.release();
    return;
  }
  for (Impl::Sending& sending : impl_->sendings) MPI_Wait(&sending.request, MPI_STATUS_IGNORE);
  MPI_Comm_free(&impl_->communicator);
}

int MpiTransport::rank() const { return impl_->rank; }
int MpiTransport::ranks() const { return impl_->ranks; }

void MpiTransport::send(int to, std::span<const std::byte> message) {
  impl_->drop_sent();
  bool is_last = false;
  do {
    const std::span<const std::byte> part = message.first(std::min(message.size(), kMostBytes));
    message = message.subspan(part.size());
    is_last = message.empty();
    Impl::Sending& sending = impl_->sendings.emplace_back();  // a deque leaves the others where they are
    sending.bytes.assign(part.begin(), part.end());
    check(MPI_Isend(sending.bytes.data(), static_cast<int>(part.size()), MPI_BYTE, to,
                    is_last ? kTag : kTagOfMore, impl_->communicator, &sending.request),
          "send");
  } while (!is_last);
}

std::span<const std::byte> MpiTransport::receive(int from) {
  std::size_t received = 0;
  for (bool is_last = false; !is_last;) {
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    check(MPI_Mprobe(from, MPI_ANY_TAG, impl_->communicator, &handle, &status), "receive");
    is_last = status.MPI_TAG == kTag;
    int size = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &size), "receive");
    impl_->received.resize(received + static_cast<std::size_t>(size));
    check(MPI_Mrecv(impl_->received.data() + received, size, MPI_BYTE, &handle, MPI_STATUS_IGNORE),
          "receive");
    received += static_cast<std::size_t>(size);
  }
  impl_->drop_sent();
  return impl_->received;
}

// Ranks that give different numbers of values would get anything: MPI need not notice. So the numbers are
// added up, too, and their squares: they are all the same exactly where the mean of the squares is that of
// the mean. Few values, the usual case, go with them.
void MpiTransport::add_up(std::span<std::int64_t> values) {
  constexpr std::size_t kFew = 14;
  const auto count = static_cast<std::uint64_t>(values.size());
  std::uint64_t sums[2 + kFew] = {count, count * count};
  if (values.size() <= kFew) std::copy(values.begin(), values.end(), sums + 2);
  check(MPI_Allreduce(MPI_IN_PLACE, sums, 2 + kFew, MPI_UINT64_T, MPI_SUM, impl_->communicator), "add_up");
  if (sums[0] * sums[0] != static_cast<std::uint64_t>(impl_->ranks) * sums[1])
    throw Error("MpiTransport: ranks add up different numbers of values: their worlds differ");
  if (values.size() <= kFew) {
    std::copy(sums + 2, sums + 2 + values.size(), values.begin());
    return;
  }
  if (values.size() > kMostBytes) {
    throw Error("MpiTransport: " + std::to_string(values.size()) +
                " values are added up; it must be at most 2^30");
  }
  check(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_UINT64_T, MPI_SUM,
                      impl_->communicator),
        "add_up");
}

// Parts are written in rounds, of which each takes what MPI can count.
void MpiTransport::write_together(const std::string& file, std::uint64_t offset,
                                  std::span<const std::byte> part) {
  constexpr std::uint64_t kMostInRound = std::uint64_t{1} << 30;
  MPI_File handle = MPI_FILE_NULL;
  const std::string what = file + ": cannot be written";
  // Who has no problem must not wait for those that have. (A file that some ranks could not open stays open
  // on the others: closing it would wait, too.)
  const auto check_together = [&](int result) {
    int failures = result == MPI_SUCCESS ? 0 : 1;
    MPI_Allreduce(MPI_IN_PLACE, &failures, 1, MPI_INT, MPI_SUM, impl_->communicator);
    if (failures == 0) return;
    check(result, what.c_str(), ErrorCode::io_failure);
    throw Error("MpiTransport: " + what + " by " + std::to_string(failures) + " other ranks",
                ErrorCode::io_failure);
  };
  check_together(MPI_File_open(impl_->communicator, file.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &handle));
  std::uint64_t rounds = (part.size() + kMostInRound - 1) / kMostInRound;
  MPI_Allreduce(MPI_IN_PLACE, &rounds, 1, MPI_UINT64_T, MPI_MAX, impl_->communicator);
  int result = MPI_SUCCESS;
  for (; rounds > 0; --rounds) {
    const std::span<const std::byte> now = part.first(std::min<std::size_t>(part.size(), kMostInRound));
    MPI_Status status{};
    const int written = MPI_File_write_at_all(handle, static_cast<MPI_Offset>(offset), now.data(),
                                              static_cast<int>(now.size()), MPI_BYTE, &status);
    int bytes = 0;
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    if (result == MPI_SUCCESS) result = std::cmp_equal(bytes, now.size()) ? written : MPI_ERR_IO;
    part = part.subspan(now.size());
    offset += now.size();
  }
  const int synchronized = MPI_File_sync(handle);  // which all ranks call, as they do all of these
  if (result == MPI_SUCCESS) result = synchronized;
  const int closed = MPI_File_close(&handle);
  check_together(result == MPI_SUCCESS ? closed : result);
}

}  // namespace scree
