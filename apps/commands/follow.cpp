// SPDX-License-Identifier: BSD-3-Clause
#include <apps/commands/follow.hpp>
#include <apps/report/step_report.hpp>
#include <chrono>
#include <ctime>
#include <mapjoin/io/g2o/growing_g2o.hpp>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/incremental/part_maker.hpp>
#include <thread>
#include <type_traits>
#include <utility>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks(50);

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// The estimate of a log that grows.
template <int Dim>
class GrowingMap {
 public:
  GrowingMap(const Options& options, StepReport& report) : options_(options), report_(report), maker_(new_maker()) {}

  /// `whole` reads the log up to and with the news, for where these concern what is in a map already.
  template <typename Whole>
  Expected<void> add(const Log<Dim>& news, Whole&& whole) {
    if (maker_.add(news)) return join_complete(false);
    Expected<AnyLog> log = whole();
    if (!log) return tl::unexpected(log.error());
    maker_ = new_maker();
    map_ = IncrementalJoin<Dim>();
    count_ = 0;
    maker_.add(std::get<Log<Dim>>(*log));
    return join_complete(false);
  }

  /// Makes parts of what is complete, at the end of all, and joins them.
  Expected<void> join_complete(bool is_end) {
    auto parts = maker_.take(is_end);
    if (!parts) return tl::unexpected(parts.error());
    if (count_ == 0 && parts->size() > 1) return add_at_once(*std::move(parts));
    for (Part<Dim>& part : *parts) {
      Step step{++count_, 1, {}, {}, {}, 0.0};
      if (part.stretch) {
        step.begin = maker_.name(part.stretch->begin);
        step.end = maker_.name(part.stretch->end);
      }
      const double start = cpu_seconds();
      step.added = map_.add(std::move(part));
      step.seconds = cpu_seconds() - start;
      if (auto said = report_.add(step); !said) return said;
    }
    return {};
  }

 private:
  PartMaker<Dim> new_maker() const { return PartMaker<Dim>(options_.run.split, options_.run.solver); }

  Expected<void> add_at_once(std::vector<Part<Dim>> parts) {
    Step step{1, parts.size(), maker_.name(parts.front().stretch->begin), maker_.name(parts.back().stretch->end), {}, 0.0};
    count_ = parts.size();
    const double start = cpu_seconds();
    step.added = map_.add_all(std::move(parts));
    step.seconds = cpu_seconds() - start;
    return report_.add(step);
  }

  const Options& options_;
  StepReport& report_;
  PartMaker<Dim> maker_;
  IncrementalJoin<Dim> map_;
  std::size_t count_ = 0;
};

class Follower {
 public:
  Follower(const Options& options, GrowingG2o file, StepReport report)
      : options_(options), file_(std::move(file)), report_(std::move(report)) {}

  /// Until the file has not grown for a while, a stop is requested, or something in it is wrong, which is then the fault.
  Expected<FollowedLog> follow(double idle_seconds, const std::stop_token& stop) {
    using Clock = std::chrono::steady_clock;
    std::optional<Error> fault;
    auto last_growth = Clock::now();
    const auto is_idle = [&] { return std::chrono::duration<double>(Clock::now() - last_growth).count() > idle_seconds; };
    do {
      const std::size_t size = file_.size();
      if (auto added = add(file_.appended(), fault); !added) return tl::unexpected(added.error());
      if (file_.size() > size) {
        last_growth = Clock::now();
      } else {
        std::this_thread::sleep_for(kBetweenLooks);
      }
    } while (!fault && !stop.stop_requested() && !is_idle());
    if (!fault && !stop.stop_requested()) {
      if (auto added = add(file_.rest(), fault); !added) return tl::unexpected(added.error());
    }
    return finished(std::move(fault));
  }

 private:
  Expected<void> add(Expected<std::optional<AnyLog>> news, std::optional<Error>& fault) {
    if (!news) fault = news.error();
    if (!news || !*news) return {};
    return std::visit([&](auto& any) { return add(any); }, **news);
  }

  template <int Dim>
  Expected<void> add(Log<Dim>& news) {
    if (options_.covariance == Covariance::kIdentity) use_identity_covariance(news);
    if (std::holds_alternative<std::monostate>(map_)) map_.emplace<GrowingMap<Dim>>(options_, report_);
    auto* map = std::get_if<GrowingMap<Dim>>(&map_);
    if (!map) return bad_input(options_.input.string() + ": edges in the plane and in space are in one file");
    return map->add(news, [&] { return weighted_whole(); });
  }

  Expected<AnyLog> weighted_whole() const {
    auto log = file_.whole();
    if (log && options_.covariance == Covariance::kIdentity) {
      std::visit([](auto& any) { use_identity_covariance(any); }, *log);
    }
    return log;
  }

  Expected<FollowedLog> finished(std::optional<Error> fault) {
    if (std::holds_alternative<std::monostate>(map_)) {
      return tl::unexpected(
          fault.value_or(Error{ErrorKind::kBadInput, options_.input.string() + ": the log has no edges yet"}));
    }
    auto completed = std::visit(
        [](auto& map) -> Expected<void> {
          if constexpr (std::is_same_v<std::decay_t<decltype(map)>, std::monostate>) {
            return {};
          } else {
            return map.join_complete(true);
          }
        },
        map_);
    if (!completed) return tl::unexpected(completed.error());
    return file_.whole().map([&](AnyLog&& log) { return FollowedLog{std::move(log), std::move(fault)}; });
  }

  const Options& options_;
  GrowingG2o file_;
  StepReport report_;
  std::variant<std::monostate, GrowingMap<2>, GrowingMap<3>> map_;
};

}  // namespace

void add_following(Subcommand& command, FollowOptions& options) {
  command.group("Following");
  command.flag("--follow", options.wanted,
               "LOG is a g2o file that is still being written: join it map by map (of 10 poses, unless something else is asked "
               "for), say what each map did, and run on the whole when it is complete or at Ctrl-C");
  command.number<double>("--idle", options.idle_seconds, 0.0, "SECONDS",
                         "It is complete when it has not grown for so long [5]");
  command.path("--steps", options.steps, "FILE|-",
               "Write a line of JSON for every map that is added; with - nothing else goes to standard output");
}

std::vector<std::string> check_following(const Subcommand& command, const Options& options, const FollowOptions& following) {
  std::vector<std::string> violations;
  for (const std::string name : {"--idle", "--steps"}) {
    if (command.is_given(name) && !following.wanted) violations.push_back(name + " is for --follow");
  }
  if (following.steps == "-" && options.report_on_stdout()) {
    violations.emplace_back("--steps and --report cannot both go to standard output");
  }
  return violations;
}

Expected<FollowedLog> follow(const Options& options, const FollowOptions& following, const std::stop_token& stop) {
  auto file = GrowingG2o::open(options.input, options.read);
  if (!file) return tl::unexpected(file.error());
  auto report = StepReport::open(following.steps, options.quiet);
  if (!report) return tl::unexpected(report.error());
  return Follower(options, *std::move(file), *std::move(report)).follow(following.idle_seconds, stop);
}

}  // namespace mapjoin::apps
