#include "arbox/cli/folder_watch.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::cli {
namespace {

constexpr std::uint32_t kArrival = IN_CLOSE_WRITE | IN_MOVED_TO;
constexpr std::uint32_t kDeparture = IN_DELETE | IN_MOVED_FROM;
constexpr std::uint32_t kGone = IN_DELETE_SELF | IN_MOVE_SELF | IN_UNMOUNT | IN_IGNORED;

/// Signals that ask to stop come through a descriptor from here on.
int stop_descriptor() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return ::signalfd(-1, &signals, SFD_NONBLOCK | SFD_CLOEXEC);
}

std::int64_t nanoseconds(const timespec& time) {
  return std::int64_t{1000000000} * time.tv_sec + time.tv_nsec;
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

FolderWatch::FolderWatch(std::filesystem::path folder)
    : folder_(std::move(folder)),
      notify_(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)),
      signals_(stop_descriptor()) {
  if (!std::filesystem::is_directory(folder_)) {
    throw IoError(folder_.string() + ": expected a folder to watch");
  }
  const std::uint32_t mask = kArrival | kDeparture | IN_DELETE_SELF | IN_MOVE_SELF | IN_ONLYDIR;
  if (notify_.get() < 0 || ::inotify_add_watch(notify_.get(), folder_.c_str(), mask) < 0) {
    throw IoError(folder_.string() + ": cannot be watched: " + std::strerror(errno));
  }
}

FolderEvents FolderWatch::events(bool block) {
  std::array<pollfd, 2> sources{{{notify_.get(), POLLIN, 0}, {signals_.get(), POLLIN, 0}}};
  FolderEvents events;
  if (::poll(sources.data(), sources.size(), block ? -1 : 0) <= 0) return events;
  events.stop = sources[1].revents != 0;
  if (sources[0].revents != 0) read_events(events);
  return events;
}

void FolderWatch::read_events(FolderEvents& events) {
  alignas(inotify_event) std::array<char, 1 << 16> buffer;
  for (;;) {
    const ssize_t count = ::read(notify_.get(), buffer.data(), buffer.size());
    if (count <= 0) return;
    for (const char* place = buffer.data(); place < buffer.data() + count;) {
      const auto* event = reinterpret_cast<const inotify_event*>(place);
      place += sizeof(inotify_event) + event->len;
      if ((event->mask & kGone) != 0) {
        throw IoError(folder_.string() + ": the watched folder was removed or moved");
      }
      events.overflow = events.overflow || (event->mask & IN_Q_OVERFLOW) != 0;
      if (event->len == 0 || (event->mask & IN_ISDIR) != 0) continue;
      if ((event->mask & kArrival) != 0) events.arrived.emplace_back(event->name);
      if ((event->mask & kDeparture) != 0) events.left.emplace_back(event->name);
    }
  }
}

bool find_file_state(const std::filesystem::path& path, FileState& state) {
  struct stat status;
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  state = {.inode = status.st_ino,
           .size = static_cast<std::uint64_t>(status.st_size),
           .modified = nanoseconds(status.st_mtim),
           .changed = nanoseconds(status.st_ctim)};
  return true;
}

bool is_being_written(const std::filesystem::path& path) {
  // A read lease is refused while somebody writes.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) return false;
  if (::fcntl(file.get(), F_SETLEASE, F_RDLCK) != 0) return errno == EAGAIN;
  ::fcntl(file.get(), F_SETLEASE, F_UNLCK);
  return false;
}

}  // namespace arbox::cli
