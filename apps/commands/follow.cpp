// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <apps/commands/follow.hpp>
#include <apps/commands/follow_steps.hpp>
#include <apps/exit_code.hpp>
#include <apps/process.hpp>
#include <chrono>
#include <ctime>
#include <mapjoin/io/formats/log_format.hpp>
#include <mapjoin/io/g2o/growing_g2o.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/incremental/robust_incremental_join.hpp>
#include <mapjoin/join/incremental/submap_update_maker.hpp>
#include <mapjoin/model/error.hpp>
#include <thread>
#include <utility>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks(50);

/// The map of a growing log.
template <int Dim>
class GrowingMap {
 public:
  GrowingMap(const Options& options, StepReport& report)
      : options_(options), report_(report), maker_(new_maker()), map_(new_map()) {}

  /// Adds the news of a log; `whole` reads the log up to and with them, in case all maps must be made anew.
  template <typename Whole>
  void add(const Log<Dim>& news, Whole&& whole) {
    if (!maker_.add(news)) {
      maker_ = new_maker();
      map_ = new_map();
      count_ = 0;
      maker_.add(whole());
    }
    join_complete(false);
  }

  /// Makes updates of the complete local maps, or of all at the end, and joins them: the first ones at once, the others one by
  /// one.
  void join_complete(bool is_end) {
    for (const RemadeMap<Dim>& of : maker_.take_remade()) {
      std::visit([&](auto& map) { map.keep_more(of.update, of.map).value(); }, map_);
    }
    std::vector<SubmapUpdate<Dim>> updates = maker_.take(is_end).value();
    if (count_ == 0 && updates.size() > 1) {
      const Step step{1, updates.size(), Way{first_pose(updates.front()), last_pose(updates.back())}};
      return report(step, [&](auto& map) { return robustly(map.add_all(std::move(updates))); });
    }
    for (SubmapUpdate<Dim>& update : updates) {
      Step step{count_ + 1};
      if (!update.segments.empty()) step = {count_ + 1, 1, Way{first_pose(update), last_pose(update)}};
      report(step, [&](auto& map) { return robustly(map.add(std::move(update))); });
    }
  }

 private:
  using Map = std::variant<IncrementalJoin<Dim>, RobustIncrementalJoin<Dim>>;

  static Expected<RobustlyAdded> robustly(Expected<RobustlyAdded> done) { return done; }
  static Expected<RobustlyAdded> robustly(const Expected<AddedUpdate>& added) {
    return added.map([](const AddedUpdate& added) { return RobustlyAdded{.added = added}; });
  }
  Map new_map() const {
    return options_.robust ? Map(RobustIncrementalJoin<Dim>(*options_.robust)) : Map(IncrementalJoin<Dim>());
  }
  SubmapUpdateMaker<Dim> new_maker() const { return SubmapUpdateMaker<Dim>(options_.run.split, options_.run.solver); }

  template <typename Add>
  void report(Step step, Add&& add) {
    count_ += step.count;
    const std::clock_t start = std::clock();
    step.done = std::visit(std::forward<Add>(add), map_).value();
    step.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (const auto* robust = std::get_if<RobustIncrementalJoin<Dim>>(&map_)) step.left_out = robust->left_out().size();
    report_.add(step);
  }

  const Options& options_;
  StepReport& report_;
  SubmapUpdateMaker<Dim> maker_;
  Map map_;
  std::size_t count_ = 0;
};

/// Bad input if a log can be read, but not as g2o.
void demand_g2o(const Options& options) {
  ReadOptions as_g2o = options.read;
  as_g2o.from = LogFormat::kG2o;
  if (open_log(options.input, as_g2o) || !open_log(options.input, options.read)) return;
  const std::string log = options.input.string();
  fail(ErrorKind::kBadInput,
       fmt::format("{}: only g2o can be followed, and this is another format; `mapjoin convert {} LOG.g2o` makes g2o of it",
                   log, log));
}

class Follower {
 public:
  Follower(const Options& options, const std::filesystem::path& steps)
      : options_(options), file_(GrowingG2o::open(options.input, options.read).value()), report_(steps, options.quiet) {}

  /// Follows the file until it has not grown for a while, a stop is requested, or something in it is wrong, which is then the
  /// fault.
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
    const bool is_complete = !fault_ && !stop.stop_requested();
    if (is_complete) add(file_.rest());
    return finished(is_complete && !fault_);
  }

 private:
  void add(Expected<std::optional<AnyLog>> news) {
    if (!news) fault_ = news.error();
    if (news && *news) std::visit([&](auto& any) { add(any); }, **news);
  }

  template <int Dim>
  void add(Log<Dim>& news) {
    if (!has_map()) map_.emplace<GrowingMap<Dim>>(options_, report_);
    auto* const map = std::get_if<GrowingMap<Dim>>(&map_);
    if (!map) fail(ErrorKind::kBadInput, options_.input.string() + ": edges in the plane and in space are in one file");
    take_weights(options_, news);
    map->add(news, [&] {
      auto whole = std::get<Log<Dim>>(file_.so_far().value());
      take_weights(options_, whole);
      return whole;
    });
  }

  FollowedLog finished(bool is_complete) {
    if (!has_map()) demand_g2o(options_);
    if (!has_map() && fault_) fail(fault_->kind, fault_->message);
    if (!has_map()) fail(ErrorKind::kBadInput, options_.input.string() + ": the log has no edges yet");
    if (auto* map = std::get_if<GrowingMap<2>>(&map_)) map->join_complete(true);
    if (auto* map = std::get_if<GrowingMap<3>>(&map_)) map->join_complete(true);
    return {(is_complete ? file_.whole() : file_.so_far()).value(), fault_};
  }

  bool has_map() const { return map_.index() > 0; }

  const Options& options_;
  GrowingG2o file_;
  StepReport report_;
  std::variant<std::monostate, GrowingMap<2>, GrowingMap<3>> map_;  ///< Set once the dimension of the log is known.
  std::optional<Error> fault_;
};

}  // namespace

void add_following(Subcommand& command, FollowOptions& options) {
  command.group("Following");
  command.flag("--follow", options.wanted,
               "LOG is a g2o file that is still being written: join it map by map (of 10 poses, unless something else is asked "
               "for), say what each map did, and run on the whole when it is complete or at Ctrl-C; with --robust wrong "
               "closures are left "
               "out on the way, too");
  command.number("--idle", options.idle_seconds, 0.0, "SECONDS", "It is complete when it has not grown for so long");
  command.path("--steps", options.steps, "FILE|-",
               "Write a line of JSON for every map that is added; with - nothing else goes to standard output");
}

std::vector<std::string> check_following(const Subcommand& command, const Options& options, const FollowOptions& following) {
  std::vector<std::string> violations;
  for (const std::string name : {"--idle", "--steps"}) {
    if (command.is_given(name) && !following.wanted) violations.push_back(name + " is for --follow");
  }
  if (following.wanted && options.association) {
    violations.emplace_back("--follow goes by the ids of features, which --associate ignores");
  }
  if (following.wanted && command.is_given("--inflate")) {
    violations.emplace_back("--inflate is for a log that is complete: --follow does not know yet which edges are odometry");
  }
  return violations;
}

FollowedLog follow(const Options& options, const FollowOptions& following, const std::stop_token& stop) {
  Follower follower(options, following.steps);
  wait_despite_stop();  // A stop ends the following only: steps and the map are written to their end.
  return follower.follow(following.idle_seconds, stop);
}

}  // namespace mapjoin::apps
