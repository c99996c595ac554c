#include "arbox/training/gloo_communicator.h"

#include <gloo/allreduce.h>
#include <gloo/barrier.h>
#include <gloo/math.h>
#include <gloo/rendezvous/context.h>
#include <gloo/transport/tcp/device.h>
#include <torch/csrc/distributed/c10d/TCPStore.hpp>

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/training/internal/local_address.h"

namespace arbox::training {
namespace {

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

const char* variable(const char* name) {
  const char* text = std::getenv(name);
  return text != nullptr && *text != '\0' ? text : nullptr;
}

int whole_number(const char* name, int low, int high) {
  const char* text = variable(name);
  int number = 0;
  const char* end = text == nullptr ? nullptr : text + std::strlen(text);
  const bool read = text != nullptr && std::from_chars(text, end, number).ptr == end;
  if (!read || number < low || number > high) {
    throw ConfigError(std::string(name) + ": expected a whole number from " + std::to_string(low) +
                      " to " + std::to_string(high) + ", got " +
                      (text == nullptr ? "nothing" : "'" + std::string(text) + "'"));
  }
  return number;
}

/// LibTorch's store as Gloo wants it.
class RendezvousStore : public gloo::rendezvous::Store {
 public:
  explicit RendezvousStore(c10d::Store& store) : store_(store) {}

  void set(const std::string& key, const std::vector<char>& data) override {
    store_.set(key, {data.begin(), data.end()});
  }
  std::vector<char> get(const std::string& key) override {
    const auto data = store_.get(key);
    return {data.begin(), data.end()};
  }
  void wait(const std::vector<std::string>& keys) override { store_.wait(keys); }
  void wait(const std::vector<std::string>& keys,
            const std::chrono::milliseconds& timeout) override {
    store_.wait(keys, timeout);
  }

 private:
  c10d::Store& store_;
};

std::shared_ptr<gloo::transport::Device> make_device(const ProcessGroup& group) {
  gloo::transport::tcp::attr attributes;
  if (const char* interface = variable("GLOO_SOCKET_IFNAME")) {
    attributes.iface = interface;
  } else {
    attributes.hostname = internal::local_address(group.master_address, group.master_port);
  }
  return gloo::transport::tcp::CreateDevice(attributes);
}

c10d::TCPStoreOptions store_options(const ProcessGroup& group, double timeout_seconds) {
  c10d::TCPStoreOptions options;
  options.port = group.master_port;
  options.isServer = group.rank == 0;
  options.numWorkers = static_cast<std::size_t>(group.size);
  options.timeout = milliseconds(timeout_seconds);
  return options;
}

template <class Number>
void all_reduce(const std::shared_ptr<gloo::Context>& context, Number* numbers, std::size_t count) {
  gloo::AllreduceOptions options(context);
  options.setOutput(numbers, count);
  options.setReduceFunction(
      static_cast<void (*)(void*, const void*, const void*, std::size_t)>(&gloo::sum<Number>));
  gloo::allreduce(options);
}

}  // namespace

ProcessGroup ProcessGroup::from_environment() {
  ProcessGroup group;
  if (variable("WORLD_SIZE") == nullptr) return group;
  group.size = whole_number("WORLD_SIZE", 1, 65536);
  if (group.size == 1) return group;
  group.rank = whole_number("RANK", 0, group.size - 1);
  if (const char* address = variable("MASTER_ADDR")) group.master_address = address;
  if (variable("MASTER_PORT") != nullptr) {
    group.master_port = static_cast<std::uint16_t>(whole_number("MASTER_PORT", 1, 65535));
  }
  return group;
}

struct GlooCommunicator::Connection {
  ProcessGroup group;
  c10::intrusive_ptr<c10d::TCPStore> store;
  std::shared_ptr<gloo::rendezvous::Context> context;

  template <class Call>
  void attempt(const char* what, const Call& call) const {
    try {
      call();
    } catch (const std::exception& error) {
      std::ostringstream text;
      text << "data-parallel run: process " << group.rank << " of " << group.size << " cannot "
           << what << " (master " << group.master_address << ':' << group.master_port
           << "): " << error.what();
      throw IoError(text.str());
    }
  }
};

GlooCommunicator::GlooCommunicator(const ProcessGroup& group, double timeout_seconds)
    : connection_(std::make_unique<Connection>()) {
  Connection& connection = *connection_;
  connection.group = group;
  connection.attempt("meet the others", [&] {
    connection.store = c10::make_intrusive<c10d::TCPStore>(group.master_address,
                                                           store_options(group, timeout_seconds));
    RendezvousStore store(*connection.store);
    auto device = make_device(group);
    connection.context = std::make_shared<gloo::rendezvous::Context>(group.rank, group.size);
    connection.context->setTimeout(milliseconds(timeout_seconds));
    connection.context->connectFullMesh(store, device);
  });
  wait(timeout_seconds);
}

GlooCommunicator::~GlooCommunicator() = default;

int GlooCommunicator::rank() const { return connection_->group.rank; }

int GlooCommunicator::size() const { return connection_->group.size; }

void GlooCommunicator::sum(at::Tensor& tensor) {
  const auto type = tensor.scalar_type();
  if (type != at::kFloat && type != at::kDouble && type != at::kLong) {
    throw InvalidArgument("GlooCommunicator: expected float32, float64 or int64, got " +
                          std::string(c10::toString(type)));
  }
  if (tensor.numel() == 0) return;
  at::Tensor numbers = tensor.contiguous();
  const auto count = static_cast<std::size_t>(numbers.numel());
  connection_->attempt("add up numbers with the others", [&] {
    if (type == at::kFloat) all_reduce(connection_->context, numbers.data_ptr<float>(), count);
    if (type == at::kDouble) all_reduce(connection_->context, numbers.data_ptr<double>(), count);
    if (type == at::kLong) {
      all_reduce(connection_->context, numbers.data_ptr<std::int64_t>(), count);
    }
  });
  if (!numbers.is_same(tensor)) tensor.copy_(numbers);
}

void GlooCommunicator::wait(double seconds) {
  connection_->attempt("wait for the others", [&] {
    gloo::BarrierOptions options(connection_->context);
    options.setTimeout(milliseconds(seconds));
    gloo::barrier(options);
  });
}

std::unique_ptr<Communicator> make_communicator(const ProcessGroup& group, double timeout_seconds) {
  if (group.size == 1) return std::make_unique<Communicator>();
  return std::make_unique<GlooCommunicator>(group, timeout_seconds);
}

}  // namespace arbox::training
