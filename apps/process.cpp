// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <tbb/info.h>
#include <unistd.h>

#include <algorithm>
#include <apps/exit_code.hpp>
#include <apps/process.hpp>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

extern "C" {  // Null if the BLAS is not OpenBLAS.
[[gnu::weak]] char* openblas_get_config();
[[gnu::weak]] int openblas_get_num_threads();
[[gnu::weak]] void openblas_set_num_threads(int);
[[gnu::weak]] int blas_thread_shutdown_();
}

namespace mapjoin::apps {
namespace {

constexpr std::int64_t kMegabyte = 1 << 20;
constexpr std::int64_t kBuffer = 128 * kMegabyte;   ///< OpenBLAS's buffer for each calling thread (BUFFER_SIZE of x86-64).
constexpr std::int64_t kArena = 128 * kMegabyte;    ///< Address space that malloc asks for in each thread, to keep half of it.
constexpr std::int64_t kSmallMap = 32 * kMegabyte;  ///< Memory for reading and mapping a small log.

/// The limit of a resource in bytes; nullopt if there is none.
std::optional<std::int64_t> limit_of(int resource) {
  ::rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return {};
  return static_cast<std::int64_t>(limit.rlim_cur);
}

/// Address space of the program and its libraries (bytes), without other mappings: OpenBLAS's threads take theirs meanwhile.
std::int64_t mapped_files() {
  std::ifstream maps("/proc/self/maps");  // begin-end permissions offset device inode, and the file
  std::string word;
  std::uint64_t begin = 0, end = 0, inode = 0;
  std::int64_t bytes = 0;
  char dash = 0;
  while (maps >> std::hex >> begin >> dash >> end >> word >> word >> word >> std::dec >> inode && std::getline(maps, word)) {
    if (inode != 0) bytes += static_cast<std::int64_t>(end - begin);
  }
  return bytes;
}

/// The number of TBB's threads or, if more, of OpenBLAS's own, which started before main() and take their buffers whatever is
/// asked of them later.
std::int64_t thread_count() {
  const int of_blas = openblas_get_num_threads ? openblas_get_num_threads() - 1 : 0;
  return std::max<std::int64_t>(tbb::info::default_concurrency(), of_blas);
}

Expected<void> check_limit(std::int64_t needed, std::optional<std::int64_t> limit, const char* what, const char* option) {
  if (!limit || *limit >= needed) return {};
  return tl::unexpected(
      Error{ErrorKind::kTooLarge,
            fmt::format("{} is limited to {} kB, and {} kB are needed to begin with (threads: {}): raise the limit "
                        "(`ulimit {} {}`) or give fewer processors (`taskset`)",
                        what, *limit / 1024, needed / 1024, thread_count(), option, needed / 1024)});
}

/// The signal that ends waiting reads and writes of the main thread.
constexpr int kWakes = SIGUSR1;
constexpr ::timespec kAgainAfter{0, 50'000'000};

/// The time within which signals are one request: `timeout` sends its own to the process and to the process's group.
constexpr std::chrono::milliseconds kOneRequest(200);

extern "C" void on_missing_page(int) {
  constexpr std::string_view kSentence = "mapjoin: an input file was cut short while it was read\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, kSentence.data(), kSentence.size());
  ::_exit(static_cast<int>(ExitCode::kBadInput));
}

}  // namespace

void occupy_standard_streams() {
  const auto is_closed = [](int stream) { return ::fcntl(stream, F_GETFD) < 0; };
  // Each call takes the lowest descriptor that is free. A socket without a peer cannot be opened by its path either.
  if (is_closed(STDIN_FILENO)) ::open("/dev/null", O_RDONLY);
  if (is_closed(STDOUT_FILENO)) ::socket(AF_UNIX, SOCK_STREAM, 0);
  if (is_closed(STDERR_FILENO)) ::open("/dev/null", O_WRONLY);
}

Expected<void> check_process_limits() {
  const std::int64_t stack = limit_of(RLIMIT_STACK).value_or(2 * kMegabyte);  // of each thread, as glibc chooses it
  const std::int64_t data = kSmallMap + thread_count() * (kBuffer + stack);
  return check_limit(mapped_files() + data + thread_count() * kArena, limit_of(RLIMIT_AS), "address space", "-v").and_then([&] {
    return check_limit(data, limit_of(RLIMIT_DATA), "data", "-d");
  });
}

void keep_blas_on_one_thread() {
  if (!openblas_set_num_threads || !blas_thread_shutdown_) return;
  if (limit_of(RLIMIT_AS) || limit_of(RLIMIT_DATA)) openblas_set_num_threads(static_cast<int>(thread_count()) + 1);
  openblas_set_num_threads(1);
  blas_thread_shutdown_();
}

std::string blas_name() {
  return openblas_get_config ? openblas_get_config() : "BLAS";
}

void end_on_truncated_input() {
  std::signal(SIGBUS, on_missing_page);
}

Interruption::Interruption() {
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  struct sigaction waking {};
  waking.sa_handler = [](int) {};  // Without SA_RESTART.
  ::sigaction(kWakes, &waking, nullptr);

  // The signals are blocked in this thread and in all that it starts, and one thread waits for them. Handlers would not do:
  // METIS puts its own in their place while it works, and takes SIGTERM for an error.
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM}) ::sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals, source = source_, main = ::pthread_self()]() mutable {
    while (::sigwaitinfo(&signals, nullptr) < 0) {
    }
    source.request_stop();
    const auto from_here_a_second = std::chrono::steady_clock::now() + kOneRequest;
    do {  // It may come just before a call that waits for ever.
      ::pthread_kill(main, kWakes);
    } while (::sigtimedwait(&signals, nullptr, &kAgainAfter) < 0 || std::chrono::steady_clock::now() < from_here_a_second);
    std::_Exit(static_cast<int>(ExitCode::kInterrupted));
  }).detach();
}

void wait_despite_stop() {
  sigset_t waking;
  ::sigemptyset(&waking);
  ::sigaddset(&waking, kWakes);
  ::pthread_sigmask(SIG_BLOCK, &waking, nullptr);
}

}  // namespace mapjoin::apps
