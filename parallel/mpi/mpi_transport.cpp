// See scree/mpi.h. Sends are begun at once and kept until MPI has taken them; a message's length comes with
// it.
#include <scree/error.h>
#include <scree/mpi.h>

#include <deque>
#include <exception>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace scree {

namespace {

constexpr int kTag = 1;

void check(int result, const std::string& what) {
  if (result == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = {};
  int length = 0;
  MPI_Error_string(result, text, &length);
  throw Error("MpiTransport: " + what + ": " + std::string(text, static_cast<std::size_t>(length)));
}

int checked_size(std::size_t bytes, const std::string& what) {
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw Error("MpiTransport: " + what + " of " + std::to_string(bytes) +
                " bytes; MPI takes less than 2 GiB at once: use more ranks");
  }
  return static_cast<int>(bytes);
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
  const std::string what = "a message to rank " + std::to_string(to);
  const int size = checked_size(message.size(), what);
  impl_->drop_sent();
  Impl::Sending& sending = impl_->sendings.emplace_back();  // a deque leaves the others where they are
  sending.bytes.assign(message.begin(), message.end());
  check(MPI_Isend(sending.bytes.data(), size, MPI_BYTE, to, kTag, impl_->communicator, &sending.request),
        what);
}

std::span<const std::byte> MpiTransport::receive(int from) {
  const std::string what = "a message of rank " + std::to_string(from);
  MPI_Message handle = MPI_MESSAGE_NULL;
  MPI_Status status;
  check(MPI_Mprobe(from, kTag, impl_->communicator, &handle, &status), what);
  int size = 0;
  check(MPI_Get_count(&status, MPI_BYTE, &size), what);
  impl_->received.resize(static_cast<std::size_t>(size));
  check(MPI_Mrecv(impl_->received.data(), size, MPI_BYTE, &handle, MPI_STATUS_IGNORE), what);
  impl_->drop_sent();
  return impl_->received;
}

// Ranks that give different numbers of values would get anything: MPI need not notice.
void MpiTransport::add_up(std::span<std::int64_t> values) {
  std::int64_t sizes[2] = {static_cast<std::int64_t>(values.size()),
                           -static_cast<std::int64_t>(values.size())};
  check(MPI_Allreduce(MPI_IN_PLACE, sizes, 2, MPI_INT64_T, MPI_MAX, impl_->communicator), "add_up");
  if (sizes[0] != -sizes[1]) {
    throw Error("MpiTransport: ranks add up " + std::to_string(-sizes[1]) + " to " +
                std::to_string(sizes[0]) + " values: their worlds differ");
  }
  const int count = checked_size(values.size(), "values to add up");
  check(MPI_Allreduce(MPI_IN_PLACE, values.data(), count, MPI_UINT64_T, MPI_SUM, impl_->communicator),
        "add_up");
}

}  // namespace scree
