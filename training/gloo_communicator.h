#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "arbox/training/communicator.h"

namespace arbox::training {

/// Where the processes of a data-parallel run find each other.
struct ProcessGroup {
  int rank = 0;
  int size = 1;
  /// Host name or address of process 0, as the others reach it, and a free port there.
  std::string master_address = "127.0.0.1";
  std::uint16_t master_port = 29500;

  /// From RANK, WORLD_SIZE, MASTER_ADDR and MASTER_PORT; one process if WORLD_SIZE is not set.
  /// Throws ConfigError that names the variable.
  static ProcessGroup from_environment();
};

/// Sums over processes by TCP with Gloo; sums are equal to the last bit in all processes. Data
/// goes out of the network interface that leads to the master, or the one that GLOO_SOCKET_IFNAME
/// names. Not encrypted: for trusted networks.
class GlooCommunicator : public Communicator {
 public:
  /// Waits until all processes are there. A process that does not come, or that lets the others
  /// wait for longer than `timeout_seconds` in one sum, makes the call throw IoError.
  GlooCommunicator(const ProcessGroup& group, double timeout_seconds);
  ~GlooCommunicator() override;
  GlooCommunicator(const GlooCommunicator&) = delete;
  GlooCommunicator& operator=(const GlooCommunicator&) = delete;

  int rank() const override;
  int size() const override;
  /// float32, float64 or int64, on the CPU; throws InvalidArgument otherwise.
  void sum(at::Tensor& tensor) override;
  void wait(double seconds) override;

 private:
  struct Connection;
  std::unique_ptr<Connection> connection_;
};

/// A GlooCommunicator, or a lone Communicator if the group is of one.
std::unique_ptr<Communicator> make_communicator(const ProcessGroup& group, double timeout_seconds);

}  // namespace arbox::training
