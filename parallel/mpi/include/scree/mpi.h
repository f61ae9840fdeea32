// MpiTransport: messages between the processes of an MPI program, for a distributed world. Of the target
// scree::mpi, which builds with -DSCREE_MPI=ON; the library itself knows no MPI.
#pragma once

#include <mpi.h>
#include <scree/export.h>
#include <scree/transport.h>

#include <memory>

namespace scree {

/// The ranks of a communicator. MPI must have been initialized, with at least MPI_THREAD_FUNNELED where steps
/// have helpers, and must be finalized after the transport has ended.
class SCREE_API MpiTransport final : public Transport {
 public:
  /// All ranks of the communicator call it together. Messages are apart from those of the caller.
  /// Throws Error where MPI reports a failure.
  explicit MpiTransport(MPI_Comm communicator);
  /// All ranks end theirs together, but where an exception ends one: then MPI_Abort must follow.
  ~MpiTransport() override;
  MpiTransport(const MpiTransport&) = delete;
  MpiTransport& operator=(const MpiTransport&) = delete;

  int rank() const override;
  int ranks() const override;
  /// Throws Error where MPI reports a failure, as all of these do.
  void send(int to, std::span<const std::byte> message) override;
  std::span<const std::byte> receive(int from) override;
  void add_up(std::span<std::int64_t> values) override;
  /// By MPI's parallel input and output, which may gather parts and write them in larger pieces.
  void write_together(const std::string& file, std::uint64_t offset,
                      std::span<const std::byte> part) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace scree
