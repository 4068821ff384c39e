// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/program.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <system_error>

#include "volute/base/advice.hpp"
#include "volute/base/interrupt.hpp"
#include "volute/base/output_name.hpp"
#include "volute/base/parallel.hpp"
#include "volute/base/printable.hpp"
#include "volute/base/suggest.hpp"
#include "volute/base/version.hpp"
#include "volute/cli/command.hpp"
#include "volute/cli/console.hpp"
#include "volute/cli/help.hpp"
#include "volute/cli/input_checks.hpp"
#include "volute/cli/parse.hpp"
#include "volute/cli/piped_input.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cluster/cluster.hpp"
#include "volute/cluster/rank_streams.hpp"
#include "volute/io/reader_helper.hpp"

namespace volute::cli {
namespace {

constexpr int kDone = 0;
constexpr int kCouldNot = 1;
constexpr int kWrongUsage = 2;

int wrongUsage(const Error& error) {
  letFirstRankSpeak();
  say("volute: {}\n'volute help' lists the commands.\n", printableMessage(error.message));
  return kWrongUsage;
}

int unknownCommand(const std::string& word) {
  std::vector<std::string_view> names;
  for (const Command& command : commands()) names.push_back(command.name);
  const auto near = nearest(word, names);
  const std::string hint = near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
  return wrongUsage(
      {ErrorCode::kInvalidArgument, fmt::format("unknown command '{}'{}", word, hint)});
}

Console::Volume volumeOf(const Arguments& arguments) {
  if (arguments.flag("quiet"))
    return Console::Volume::kQuiet;
  return arguments.flag("verbose") ? Console::Volume::kVerbose : Console::Volume::kNormal;
}

/// What was printed must have arrived: a full disk behind `> file` is an error like any other.
Status flushResults() {
  if (std::fflush(stdout) == 0 && !std::ferror(stdout))
    return {};
  return fail(ErrorCode::kIo, "standard output: cannot write: {}", std::strerror(errno));
}

/// A thread that cannot be started says no more than "Resource temporarily unavailable".
std::string whatOf(const std::exception& error) {
  const auto* system = dynamic_cast<const std::system_error*>(&error);
  if (!system || system->code() != std::errc::resource_unavailable_try_again)
    return error.what();
  return fmt::format(
      "no more threads can be started ({}); raise ulimit -u and -v, or take fewer "
      "threads",
      error.what());
}

/// Exceptions that a library let through end the command, not the program without a word.
Status runGuarded(const Command& command, Arguments& arguments, Context& context) {
  PipedInputs piped;
  try {
    VOLUTE_TRY(piped.take(command, arguments, context));
    VOLUTE_TRY(checkNothingOverwritten(command, arguments));
    VOLUTE_TRY(checkNamedFiles(command, arguments, context));
    remarkOnLeftovers(command, arguments, context);
    return command.run(arguments, context);
  } catch (const std::bad_alloc&) {
    return fail(
        ErrorCode::kTooLarge,
        "there is not enough memory; take fewer frames, a lower resolution or a smaller region");
  } catch (const std::exception& error) {
    return fail(ErrorCode::kIo, "{}", whatOf(error));
  }
}

/// `help | head -1` ends as other programs do whose reader has seen enough of their text. Ranks do
/// not: a launcher would end the others.
void endByBrokenPipe() {
  if (errno != EPIPE)
    return;
  ::signal(SIGPIPE, SIG_DFL);
  ::raise(SIGPIPE);
}

int show(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  const Status status = flushResults();
  if (!status)
    endByBrokenPipe();
  if (!status)
    say("volute: {}\n", status.error().message);
  return status ? kDone : kCouldNot;
}

/// Names outputs that were not: Option::derived.
void nameOutputs(const Command& command, Arguments& arguments, Progress& progress) {
  for (const Option& option : command.options) {
    if (option.derived.empty() || arguments.given(option.name) || arguments.positionals().empty())
      continue;
    const std::string name = derivedOutput(arguments.positional(0), option.derived);
    arguments.set(option.name, name, false);
    progress.remark({RemarkCode::kNote,
                     fmt::format("writes {}", name),
                     {Hint::set(option.name).so("gives another name")}});
  }
}

int runCommand(const Command& command, Arguments arguments, const std::vector<std::string>& words) {
  Interrupt::name(command.name);
  auto team = openTeamFor(command, words);
  if (!team) {
    say("volute {}: {}\n", command.name,
        printableMessage(fullText(team.error(), optionsOf(command))));
    return kCouldNot;
  }
  const ThreadLimit threads(arguments.find<int>("threads").value_or(0));
  Console console(std::string(command.name), volumeOf(arguments), optionsOf(command),
                  arguments.flag("strict"));
  if ((*team)->size() > 1)
    Interrupt::keepExitCode();
  Context context{{console, arguments.get<Bytes>("max-memory").count}, **team, &console};
  context.json = arguments.flag("json");
  context.words = words;
  context.verbose = arguments.flag("verbose");
  nameOutputs(command, arguments, console);
  Status status = runGuarded(command, arguments, context);
  if (status) {
    status = flushResults();
    if (!status && context.team.size() == 1 && console.strictness())
      endByBrokenPipe();
  }
  const Status strict = console.strictness();
  status = context.team.agree(strict ? status : strict);
  if (!strict)
    status = strict;  // a team keeps its first error: that the work was stopped
  console.clear();
  // Launchers take the code of any process that failed.
  if (status || !context.team.leads())
    return kDone;
  std::fflush(stdout);
  say("volute {}: {}\n", command.name,
      printableMessage(fullText(status.error(), optionsOf(command))));
  return status.error().code == ErrorCode::kInvalidArgument ? kWrongUsage : kCouldNot;
}

int parseAndRun(const Command& command, const std::vector<std::string>& words) {
  const auto arguments = parseArguments(command, words);
  if (!arguments) {
    letFirstRankSpeak();
    say("volute {0}: {1}\nSee 'volute help {0}'.\n", command.name,
        printableMessage(fullText(arguments.error(), optionsOf(command))));
    return kWrongUsage;
  }
  if (arguments->flag("help"))
    return show(helpText(command));
  if (arguments->flag("version"))
    return show("volute " VOLUTE_VERSION "\n");
  if (const Status alone = checkRanks(command); !alone)
    return wrongUsage(alone.error());
  return runCommand(command, *arguments, words);
}

/// A closed pipe and a file beyond the user's limit become errors of write().
void ignoreSignalsOfWriting() {
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace

void keepFreedMemory(std::size_t bytes) {
#ifdef __GLIBC__
  constexpr std::size_t kMin = 32 << 20, kMax = 1 << 30;  // bytes; no larger mapping in glibc
  ::mallopt(M_MMAP_THRESHOLD, kMin);
  ::mallopt(M_TRIM_THRESHOLD, static_cast<int>(std::clamp(bytes, kMin, kMax)));
#endif
}

/// Streams that were closed must not become the first files that are opened. Writing to standard
/// output stays an error; messages get lost.
static void openClosedStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) < 0 && errno == EBADF)
      (void)::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
  }
}

static int chooseAndRun(int argc, char** argv) {
  openClosedStreams();
  silenceOtherRanks();
  ignoreSignalsOfWriting();
  const ReaderHelper helper(Interrupt::requested);
  const Interrupt interrupt;
  std::vector<std::string> words(argv + 1, argv + argc);
  const auto place = findCommandWord(words);
  if (!place)
    return wrongUsage(place.error());
  if (*place == words.size()) {
    const bool version = std::ranges::find(words, "--version") != words.end();
    return show(version ? "volute " VOLUTE_VERSION "\n" : overviewText());
  }
  const std::string name = words[*place];
  const Command* command = findCommand(name);
  if (!command)
    return unknownCommand(name);
  words.erase(words.begin() + static_cast<std::ptrdiff_t>(*place));
  return parseAndRun(*command, words);
}

/// Too little memory for the command line itself, and what else comes out of a library there.
template <class Run>
static int sayingWhy(Run&& run) {
  keepFreedMemory(0);
  Interrupt::explainMissingMemory();
  try {
    return run();
  } catch (const std::bad_alloc&) {
    std::fputs("volute: there is not enough memory\n", stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "volute: %s\n", whatOf(error).c_str());
  }
  return kCouldNot;
}

/// A run that was stopped ends by the signal.
static int endedBy(int code) {
  if (code == kCouldNot)
    Interrupt::endBySignal();
  return code;
}

int runProgram(int argc, char** argv) {
  return endedBy(sayingWhy([&] { return chooseAndRun(argc, argv); }));
}

int runProgram(const Command& command, int argc, char** argv) {
  return endedBy(sayingWhy([&] {
    openClosedStreams();
    silenceOtherRanks();
    ignoreSignalsOfWriting();
    const ReaderHelper helper(Interrupt::requested);
    const Interrupt interrupt;
    return parseAndRun(command, {argv + 1, argv + argc});
  }));
}

}  // namespace volute::cli
