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

/// The estimate of a log that grows.
template <int Dim>
class GrowingMap {
 public:
  GrowingMap(const Options& options, StepReport& report) : options_(options), report_(report), maker_(new_maker()) {}

  /// `whole` reads the log up to and with the news, for where these concern what is in a map already.
  template <typename Whole>
  void add(const Log<Dim>& news, Whole&& whole) {
    if (!maker_.add(news)) {
      maker_ = new_maker();
      map_ = IncrementalJoin<Dim>();
      count_ = 0;
      maker_.add(std::get<Log<Dim>>(whole()));
    }
    join_complete(false);
  }

  /// Makes parts of what is complete, at the end of all, and joins them: the first ones at once, the others one by one.
  void join_complete(bool is_end) {
    std::vector<Part<Dim>> parts = maker_.take(is_end).value();
    if (count_ == 0 && parts.size() > 1) {
      const Step step{1, parts.size(), name(parts.front(), &Stretch::begin), name(parts.back(), &Stretch::end), {}, 0.0};
      return report(step, [&] { return map_.add_all(std::move(parts)); });
    }
    for (Part<Dim>& part : parts) {
      const Step step{count_ + 1, 1, name(part, &Stretch::begin), name(part, &Stretch::end), {}, 0.0};
      report(step, [&] { return map_.add(std::move(part)); });
    }
  }

 private:
  PartMaker<Dim> new_maker() const { return PartMaker<Dim>(options_.run.split, options_.run.solver); }
  PoseId name(const Part<Dim>& part, Index Stretch::*pose) const {
    return part.stretch ? maker_.name((*part.stretch).*pose) : PoseId{};
  }

  template <typename Add>
  void report(Step step, Add&& add) {
    count_ += step.count;
    const std::clock_t start = std::clock();
    step.added = add();
    step.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    demand(report_.add(step));
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
  FollowedLog follow(double idle_seconds, const std::stop_token& stop) {
    using Clock = std::chrono::steady_clock;
    auto last_growth = Clock::now();
    const auto is_idle = [&] { return std::chrono::duration<double>(Clock::now() - last_growth).count() > idle_seconds; };
    do {
      const std::size_t size = file_.size();
      add(file_.appended());
      if (file_.size() > size) {
        last_growth = Clock::now();
      } else {
        std::this_thread::sleep_for(kBetweenLooks);
      }
    } while (!fault_ && !stop.stop_requested() && !is_idle());
    if (!fault_ && !stop.stop_requested()) add(file_.rest());
    return finished();
  }

 private:
  void add(Expected<std::optional<AnyLog>> news) {
    if (!news) fault_ = news.error();
    if (news && *news) std::visit([&](auto& any) { add(any); }, **news);
  }

  template <int Dim>
  void add(Log<Dim>& news) {
    if (!dimension_) map<Dim>().emplace(options_, report_);
    dimension_ = dimension_.value_or(Dim);
    if (*dimension_ != Dim) {
      fail(ErrorKind::kBadInput, options_.input.string() + ": edges in the plane and in space are in one file");
    }
    if (options_.covariance == Covariance::kIdentity) use_identity_covariance(news);
    map<Dim>()->add(news, [&] { return weighted_whole(); });
  }

  AnyLog weighted_whole() const {
    AnyLog log = file_.whole().value();
    if (options_.covariance == Covariance::kIdentity) std::visit([](auto& any) { use_identity_covariance(any); }, log);
    return log;
  }

  FollowedLog finished() {
    if (!dimension_ && fault_) fail(fault_->kind, fault_->message);
    if (!dimension_) fail(ErrorKind::kBadInput, options_.input.string() + ": the log has no edges yet");
    *dimension_ == 2 ? map_2d_->join_complete(true) : map_3d_->join_complete(true);
    return {file_.whole().value(), fault_};
  }

  template <int Dim>
  std::optional<GrowingMap<Dim>>& map() {
    if constexpr (Dim == 2) return map_2d_;
    if constexpr (Dim == 3) return map_3d_;
  }

  const Options& options_;
  GrowingG2o file_;
  StepReport report_;
  std::optional<int> dimension_;  ///< Of the log, once it is known,
  std::optional<GrowingMap<2>> map_2d_;
  std::optional<GrowingMap<3>> map_3d_;
  std::optional<Error> fault_;
};

}  // namespace

void add_following(Subcommand& command, FollowOptions& options) {
  command.group("Following");
  command.flag("--follow", options.wanted,
               "LOG is a g2o file that is still being written: join it map by map (of 10 poses, unless something else is asked "
               "for), say what each map did, and run on the whole when it is complete or at Ctrl-C");
  command.number("--idle", options.idle_seconds, 0.0, "SECONDS", "It is complete when it has not grown for so long");
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

FollowedLog follow(const Options& options, const FollowOptions& following, const std::stop_token& stop) {
  GrowingG2o file = GrowingG2o::open(options.input, options.read).value();
  StepReport report = StepReport::open(following.steps, options.quiet).value();
  return Follower(options, std::move(file), std::move(report)).follow(following.idle_seconds, stop);
}

}  // namespace mapjoin::apps
