// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "volute/base/plain_number.hpp"
#include "volute/base/read_text.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/scene_arguments.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/fds/people_file.hpp"
#include "volute/film/sign_views.hpp"
#include "volute/io/image_file.hpp"
#include "volute/io/output_names.hpp"
#include "volute/scene/scene_sight.hpp"
#include "volute/visibility/criteria_file.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/sign_file.hpp"
#include "volute/visibility/storeys.hpp"
#include "volute/visibility/survey_job.hpp"

namespace volute::cli {
namespace {

/// A text file; what is made of it takes several times its size.
Result<std::string> textOf(const std::string& path, const Context& context) {
  return readText(path, context.maxMemory / 16);
}

/// People who walk, as a text or database; those of FDS+Evac as a table.
Result<std::string> peopleOf(const std::string& path, const Context& context) {
  return mayHoldPeople(path) ? fdsPeopleTable(path, context.maxMemory / 16) : textOf(path, context);
}

/// "1.8,4.8": of plans, a storey each.
Result<std::vector<double>> heightsOf(const Arguments& arguments) {
  VOLUTE_ASSIGN(auto heights,
                ofOption("height", parseNumbers(arguments.get<std::string>("height"))));
  for (auto at = heights.begin(); at != heights.end(); ++at) {
    if (std::find(heights.begin(), at, *at) != at)
      return fail(ErrorCode::kInvalidArgument, "--height: {:g} is there twice", *at);
  }
  return heights;
}

/// What has no effect on other eyes than a plan's, or beside another option, is refused.
Status checkOptionsOfEyes(const Arguments& arguments) {
  const auto refuseBoth = [&](const char* option, const char* other) -> Status {
    if (!arguments.given(option) || !arguments.given(other))
      return {};
    return fail(ErrorCode::kInvalidArgument, "--{} has no effect beside --{}; omit one", option,
                other);
  };
  VOLUTE_ASSIGN(const auto heights, heightsOf(arguments));
  for (const char* eyes : {"route", "eyes", "trajectories"}) {
    if (!arguments.given(eyes))
      continue;
    for (const char* areas : {"areas", "area-layer"}) {
      if (arguments.given(areas))
        return fail(ErrorCode::kInvalidArgument, "--{}: areas are of plans; --{} has none", areas,
                    eyes);
    }
    if (heights.size() > 1)
      return fail(ErrorCode::kInvalidArgument,
                  "--height: several heights are for plans; --{} takes one", eyes);
    for (const char* option :
         {"rset", "everywhere", "fire-at", "maps", "underlay", "extinction-limit", "sight-limit"})
      VOLUTE_TRY(refuseBoth(option, eyes));
  }
  for (const char* eyes : {"eyes", "trajectories"}) VOLUTE_TRY(refuseBoth("step", eyes));
  VOLUTE_TRY(refuseBoth("eye-height", "height"));
  return refuseBoth("fire-at", "everywhere");
}

/// That of all eyes, if it is given.
Result<std::optional<double>> givenHeight(const Arguments& arguments) {
  if (!arguments.given("height"))
    return std::nullopt;
  VOLUTE_ASSIGN(const auto heights, heightsOf(arguments));
  return heights.front();
}

/// Points of a table, which says their z or leaves it to --height.
Result<std::vector<NamedPoint>> pointsOf(const Arguments& arguments, const std::string& file,
                                         const Context& context) {
  VOLUTE_ASSIGN(const auto height, givenHeight(arguments));
  VOLUTE_ASSIGN(const auto text, textOf(file, context));
  VOLUTE_ASSIGN(auto points, parsePoints(text, file, height));
  if (height && points.front().hasZ)
    return fail(ErrorCode::kInvalidArgument, "--height has no effect: {} has z; omit one", file);
  return points;
}

/// @param heights  gets those of the eyes [m], other than a plan's
Result<std::unique_ptr<Watch>> watchOf(const Arguments& arguments, const Context& context,
                                       std::vector<Remark>& remarks, std::set<double>& heights) {
  if (const auto file = arguments.find<std::string>("route")) {
    VOLUTE_ASSIGN(const auto points, pointsOf(arguments, *file, context));
    VOLUTE_ASSIGN(auto routes, routesOf(points, *file));
    for (const NamedPoint& point : points) heights.insert(point.position.z());
    VOLUTE_ASSIGN(const auto slowed,
                  ofOption("slowed", speedLaw(arguments.get<std::string>("slowed"))));
    VOLUTE_ASSIGN(const auto start,
                  ofOption("start", walkStart(arguments.get<std::string>("start"))));
    return routeWatch(std::move(routes), {arguments.get<double>("speed"), start, slowed});
  }
  if (const auto file = arguments.find<std::string>("eyes")) {
    VOLUTE_ASSIGN(const auto points, pointsOf(arguments, *file, context));
    std::vector<Vec3> eyes;
    std::vector<std::string> names;
    for (const NamedPoint& point : points) {
      eyes.push_back(point.position);
      names.push_back(point.name);
      heights.insert(point.position.z());
    }
    if (std::ranges::all_of(names, &std::string::empty))
      names.clear();
    return pointWatch(std::move(eyes), std::move(names));
  }
  if (const auto file = arguments.find<std::string>("trajectories")) {
    VOLUTE_ASSIGN(const auto height, givenHeight(arguments));
    VOLUTE_ASSIGN(const auto text, peopleOf(*file, context));
    VOLUTE_ASSIGN(auto people,
                  Trajectories::parse(text, *file, height, arguments.get<double>("eye-height")));
    if (arguments.given("eye-height") && !people.areAboveFloors()) {
      return fail(ErrorCode::kInvalidArgument,
                  "--eye-height has no effect: {} says how high all eyes are; omit it", *file);
    }
    remarks.insert(remarks.end(), people.remarks().begin(), people.remarks().end());
    people.outside([&](double z) {
      heights.insert(std::round(20 * z) / 20);  // as fine as a layer of a slice
      return false;
    });
    return trajectoryWatch(std::move(people));
  }
  return planWatch();
}

Result<double> extinctionLimit(const Arguments& arguments) {
  const auto number = arguments.find<double>("extinction-limit");
  const auto name = arguments.find<std::string>("sight-limit");
  if (!name)
    return number.value_or(0);
  VOLUTE_ASSIGN(const auto limit, sightLimit(*name));
  VOLUTE_ASSIGN(const auto law, visibilityLaw(limit.law));
  return law.c / limit.distance;
}

/// Places that pictures are taken from.
Result<std::vector<Vec3>> viewsOf(const Arguments& arguments) {
  std::vector<Vec3> eyes;
  for (const std::string& text : arguments.all("picture")) {
    VOLUTE_ASSIGN(const Vec3 eye, ofOption("picture", parseVector(text)));
    eyes.push_back(eye);
  }
  return eyes;
}

/// "24,6,1.5": where it burns, and how far around.
Result<std::vector<Vec3>> firesOf(const Arguments& arguments) {
  std::vector<Vec3> fires;
  for (const std::string& text : arguments.all("fire-at")) {
    const auto numbers = parseNumbers(text).value_or(std::vector<double>());
    if (numbers.size() != 3 || !(numbers[2] > 0)) {
      return fail(
          ErrorCode::kInvalidArgument,
          "--fire-at: '{}' is not a place; expected X,Y,RADIUS in metres, the radius above 0",
          text);
    }
    fires.emplace_back(numbers[0], numbers[1], numbers[2]);
  }
  return fires;
}

/// A drawing of the building over maps.
Result<std::shared_ptr<const PlanUnderlay>> underlayOf(const Arguments& arguments,
                                                       const Box3& bounds, std::uint64_t maxMemory,
                                                       std::vector<Remark>& remarks) {
  const auto file = arguments.find<std::string>("underlay");
  if (!file)
    return nullptr;
  UnderlayOptions options{bounds.min.head<2>(), bounds.max.head<2>()};
  options.maxMemory = maxMemory;
  options.areaLayer = arguments.find<std::string>("area-layer").value_or("");
  if (const auto text = arguments.find<std::string>("underlay-bounds")) {
    const auto ends = parseNumbers(*text).value_or(std::vector<double>());
    if (ends.size() != 4 || !(ends[0] < ends[2] && ends[1] < ends[3])) {
      return fail(
          ErrorCode::kInvalidArgument,
          "--underlay-bounds: '{}' is not a rectangle; expected X0,Y0,X1,Y1 in metres, where "
          "the drawing's lower left and upper right corners are",
          *text);
    }
    if (ends[0] >= bounds.max.x() || ends[2] <= bounds.min.x() || ends[1] >= bounds.max.y() ||
        ends[3] <= bounds.min.y()) {
      return fail(ErrorCode::kInvalidArgument,
                  "--underlay-bounds: {} is apart from the case, which reaches from {}, {} to "
                  "{}, {} m: nothing would be drawn",
                  *text, plainNumber(bounds.min.x()), plainNumber(bounds.min.y()),
                  plainNumber(bounds.max.x()), plainNumber(bounds.max.y()));
    }
    options.place = {{ends[0], ends[1]}, {ends[2], ends[3]}};
  }
  VOLUTE_ASSIGN(auto underlay, readUnderlay(*file, options, remarks));
  return std::make_shared<const PlanUnderlay>(std::move(underlay));
}

/// The smoke of a case, which is to reach the signs and the eyes' height.
Result<std::unique_ptr<SightField>> fieldOf(const Arguments& arguments, Context& context,
                                            const std::set<double>& ofEyes,
                                            SurveyRequest& request) {
  VOLUTE_ASSIGN(const auto options, sceneOptions(request.casePath, arguments, context));
  std::vector<double> heights(ofEyes.begin(), ofEyes.end());
  for (const SafetySign& sign : request.signs) heights.push_back(sign.position.z());
  if (ofEyes.empty())
    heights.push_back(request.survey.height);
  auto field = openSight(request.casePath, options, heights, request.remarks, context.progress);
  if (!field)
    return tl::unexpected(aboutOptions(std::move(field.error()), request.casePath));
  return field;
}

/// Signs for walkers of some routes, where none are walked.
void tellRoutesOfSigns(const std::vector<SafetySign>& signs, std::vector<Remark>& remarks) {
  std::vector<std::string_view> names;
  for (const SafetySign& sign : signs) {
    if (!sign.routes.empty())
      names.push_back(sign.name);
  }
  if (!names.empty())
    remarks.emplace_back(RemarkCode::kLeftOut,
                         fmt::format("the routes of signs are not used without --route: '{}' "
                                     "{} for everybody",
                                     fmt::join(names, "', '"), names.size() > 1 ? "are" : "is"));
}

/// What the report says of itself, and the files that are read besides the case's own.
SurveyRequest::Document documentOf(const Arguments& arguments) {
  const auto text = [&](const char* option) {
    return arguments.find<std::string>(option).value_or("");
  };
  SurveyRequest::Document document{
      text("title"), text("project"), text("author"), text("date"), {arguments.positional(0)}};
  if (document.author.empty())
    document.author = text("by");
  std::error_code error;
  for (const char* option :
       {"signs", "criteria", "areas", "rset", "route", "eyes", "trajectories", "underlay"}) {
    const std::string file = text(option);
    if (std::filesystem::is_regular_file(file, error))
      document.inputs.emplace_back(file);
  }
  return document;
}

/// One plan, or other eyes.
Result<SurveySummary> surveyOf(const Arguments& arguments, Context& context, double height,
                               const std::string& output, bool pdf) {
  SurveyRequest request;
  request.casePath = arguments.positional(0);
  request.output = output;
  VOLUTE_ASSIGN(request.signs, readSigns(arguments.get<std::string>("signs")));
  if (!arguments.given("route"))
    tellRoutesOfSigns(request.signs, request.remarks);
  for (const std::string& set : arguments.all("set")) {
    const auto names = split(set, ',');
    request.sets.emplace_back(names.begin(), names.end());
  }
  request.frames = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  request.survey.step = arguments.get<double>("step");
  request.survey.height = height;
  const auto maps = arguments.get<std::string>("maps");
  request.survey.maps = maps == "all"    ? Survey::Maps::kAll
                        : maps == "some" ? Survey::Maps::kSome
                                         : Survey::Maps::kNone;
  VOLUTE_ASSIGN(request.survey.extinctionLimit, extinctionLimit(arguments));
  VOLUTE_ASSIGN(request.sightFile, sightFile(arguments.get<std::string>("sight")));
  request.pdf = pdf;
  request.document = documentOf(arguments);
  VOLUTE_ASSIGN(request.profile, criteriaOf(arguments.get<std::string>("criteria")));
  request.survey.criteria = request.profile.criteria;
  if (const auto rset = arguments.find<std::string>("rset")) {
    if (request.survey.criteria.empty()) {
      return fail(ErrorCode::kInvalidArgument,
                  "--rset has no effect with --criteria none: margins are of the ASET of criteria; "
                  "omit one");
    }
    if (mayHoldPeople(*rset)) {
      VOLUTE_ASSIGN(const auto people, peopleOf(*rset, context));
      VOLUTE_ASSIGN(request.survey.rset, Rset::parse(people, *rset));
    } else {
      VOLUTE_ASSIGN(request.survey.rset, Rset::read(*rset, context.maxMemory / 16));
    }
    VOLUTE_ASSIGN(const auto heights, heightsOf(arguments));
    for (Remark& remark : request.survey.rset->remarks(heights))
      request.remarks.push_back(std::move(remark));
  }
  if (const auto file = arguments.find<std::string>("areas")) {
    VOLUTE_ASSIGN(request.survey.areas, readAreas(*file));
    VOLUTE_ASSIGN(const auto heights, heightsOf(arguments));
    VOLUTE_TRY(checkStoreys(request.survey.areas, heights, *file));
    if (request.survey.criteria.empty() &&
        std::ranges::any_of(request.survey.areas,
                            [](const auto& area) { return area.rset.has_value(); })) {
      request.remarks.push_back(
          Remark(RemarkCode::kLeftOut,
                 fmt::format("{}: rset has no effect without criteria, of whose ASET margins are",
                             *file))
              .in(*file));
    }
  }
  request.survey.everywhere = arguments.flag("everywhere");
  VOLUTE_ASSIGN(request.survey.fires, firesOf(arguments));
  VOLUTE_ASSIGN(request.survey.round, roundTime(arguments.get<std::string>("round")));
  std::set<double> ofEyes;
  VOLUTE_ASSIGN(const auto watch, watchOf(arguments, context, request.remarks, ofEyes));
  VOLUTE_ASSIGN(auto views, viewsOf(arguments));
  VOLUTE_TRY(checkFolderIsShared(request.output, context.team));
  VOLUTE_ASSIGN(const auto field, fieldOf(arguments, context, ofEyes, request));
  VOLUTE_ASSIGN(request.survey.underlay,
                underlayOf(arguments, field->bounds(), context.maxMemory, request.remarks));
  if (arguments.given("area-layer")) {
    auto& areas = request.survey.areas;
    std::vector<std::string> from(areas.size(), arguments.find<std::string>("areas").value_or(""));
    const auto& drawn = request.survey.underlay->areas;
    areas.insert(areas.end(), drawn.begin(), drawn.end());
    from.resize(areas.size(), arguments.get<std::string>("underlay"));
    VOLUTE_TRY(checkTogether(areas, from));
  }
  if (const auto name = arguments.find<std::string>("sight-limit"))
    request.remarks.push_back(limitRemark(*name, request.survey.extinctionLimit));
  request.maxMemory = context.maxMemory;
  VOLUTE_ASSIGN(const auto members, mediumMembers(request.casePath, arguments));
  VOLUTE_ASSIGN(auto pictures, SignViews::make(std::move(views), request.casePath, members,
                                               field->fillingSource(), context));
  return runSurvey(std::move(request), *field, *watch, pictures, context.progress, context.team);
}

Status runVisibility(const Arguments& arguments, Context& context) {
  const auto output = arguments.get<std::string>("output");
  const auto stats = arguments.find<std::string>("stats");
  if (stats && liesIn(*stats, output)) {
    return fail(ErrorCode::kInvalidArgument,
                "--stats: {} is in the folder that --output makes anew; give another name", *stats);
  }
  VOLUTE_TRY(checkOptionsOfEyes(arguments));
  Context::watch(output);
  VOLUTE_ASSIGN(const auto heights, heightsOf(arguments));
  const bool pdf = arguments.flag("pdf");
  VOLUTE_ASSIGN(const auto found,
                heights.size() > 1
                    ? surveyStoreys(heights, output, pdf, context.progress, context.team,
                                    [&](double height, const std::string& folder) {
                                      return surveyOf(arguments, context, height, folder, false);
                                    })
                    : surveyOf(arguments, context, heights.front(), output, pdf));
  VOLUTE_TRY(writeStats(arguments, context, {{"sight_lines", found.sightLines}}));
  const auto seen = [](double share, double time, const char* what) {
    return std::isnan(share)
               ? fmt::format("nobody is there at {} s", plainNumber(time))
               : fmt::format("{:.1f} %{} at {} s", 100 * share, what, plainNumber(time));
  };
  Report report;
  report.add("output", output)
      .add("times", found.times.size(), fmt::format("{}", found.times.size()))
      .add("sight_lines", found.sightLines, fmt::format("{}", found.sightLines))
      .add("seen_first", found.seenFirst,
           seen(found.seenFirst, found.times.front(), " of the eyes see a sign"))
      .add("seen_last", found.seenLast, seen(found.seenLast, found.times.back(), ""));
  if (!found.verdict.empty())
    report.add("verdict", found.verdict,
               fmt::format("{}", fmt::join(found.verdict, "\n             ")));
  context.print(report);
  return {};
}

std::vector<Option> visibilityOptionTable() {
  using enum ValueKind;
  std::vector<Option> options = {
      {.name = "signs",
       .kind = kFile,
       .value = "SIGNS.json",
       .help = "the signs: positions, normals, visibility laws",
       .required = true},
      {.name = "output",
       .letter = 'o',
       .kind = kFile,
       .value = "FOLDER",
       .help = "a new folder for the results; those of an earlier run in it are replaced, other "
               "files stay",
       .required = true},
      {.name = "height",
       .kind = kText,
       .value = "Z[,Z...]",
       .help = "height of the eyes: of a plan over the whole case, or of points without z [m]; "
               "several, such as 1.8,4.8, give one plan per storey, each in its own folder",
       .initial = "2"},
      {.name = "route",
       .kind = kFile,
       .value = "ROUTE.csv",
       .help = "eyes along routes: x,y[,z] [m]; several routes with a column 'route'"},
      {.name = "eyes",
       .kind = kFile,
       .value = "EYES.csv",
       .help = "eyes at these points only: x,y[,z] [m]"},
      {.name = "trajectories",
       .kind = kFile,
       .value = "FILE",
       .help = "eyes of walking people: JuPedSim's .sqlite or text format, Pathfinder's occupants "
               ".csv, people of FDS+Evac (.prt5, or .smv for all of a case), or a table "
               "id,time,x,y[,z]"},
      {.name = "eye-height",
       .kind = kNumber,
       .value = "M",
       .help = "height of the eyes above the floor, where a file of trajectories has the floor's z "
               "[m]",
       .initial = "1.8",
       .positive = true,
       .beside = "trajectories"},
      {.name = "step",
       .kind = kNumber,
       .value = "M",
       .help = "spacing of the points of a plan or a route [m]",
       .initial = "0.25",
       .least = 1e-3,
       .most = 1e3},
      {.name = "speed",
       .kind = kNumber,
       .value = "V",
       .help = "walking speed along a route [m/s]",
       .initial = "1.2",
       .positive = true,
       .beside = "route"},
      {.name = "start",
       .kind = kText,
       .value = "WHEN",
       .help = "start of the walk: seconds; smoke:K,DELAY: so many seconds after the extinction K "
               "[1/m] is reached where it begins; heard:K,DELAY: where any of the walks begins",
       .initial = "0",
       .beside = "route"},
      {.name = "slowed",
       .kind = kText,
       .value = "LAW",
       .help = "how smoke slows walkers down: none, fridolf, frantzich-nilsson, or one of these "
               "with coefficients: fridolf:0.34,3,0.2",
       .initial = "none",
       .beside = "route"},
      {.name = "criteria",
       .kind = kText,
       .value = "WHICH",
       .help = "criteria of tenability, besides the sight of signs: usual, iso-13571, nz-c4.3, "
               "nz-c4.4, none, or a file (.json); those that the case lacks data for are named",
       .initial = "usual"},
      {.name = "rset",
       .kind = kText,
       .value = "T|FILE",
       .help = "required safe egress time, compared with the ASET of a plan: seconds, a table "
               "x,y,rset or area,rset, or trajectories"},
      {.name = "areas",
       .kind = kFile,
       .value = "AREAS.json",
       .help = "areas, routes and exits of a plan by name, with verdicts of their own; without it, "
               "and beside it, the rooms that the plan's walls make"},
      {.name = "area-layer",
       .kind = kText,
       .value = "LAYER",
       .help = "closed lines of this layer of the .dxf or .svg drawing are areas too, named by the "
               "text "
               "within them",
       .beside = "underlay"},
      {.name = "everywhere",
       .help = "verdicts of a plan are of all its points; otherwise of those where people are: a "
               "floor at most 2.5 m below the eyes, head room, not on top of things, not in the "
               "fire's own place"},
      {.name = "fire-at",
       .kind = kText,
       .value = "X,Y,RADIUS",
       .help = "where it burns, for verdicts of places where people are; FDS cases say it "
               "themselves, by their heat release [m]",
       .several = true},
      framesOption("stored times, counted from 0: A <= n < B, every S-th"),
      {.name = "round",
       .kind = kChoice,
       .value = "HOW",
       .help = "round a loss between two stored times to the first (down, on the safe side), keep "
               "the interpolated time (none), or round to the second (up)",
       .initial = "down",
       .choices = {"down", "none", "up"}},
      {.name = "set",
       .kind = kText,
       .value = "NAME,NAME",
       .help = "also map when none of these signs is visible",
       .several = true},
      {.name = "maps",
       .kind = kChoice,
       .value = "WHICH",
       .help = "maps of each sign over a plan: pictures at 25 stored times and values at all, "
               "both at all, or only the loss times",
       .initial = "some",
       .choices = {"some", "all", "aset"}},
      {.name = "underlay",
       .kind = kFile,
       .value = "FILE",
       .help = "draw the building over the maps: the dark lines of a .png or .svg, or a .dxf"},
      {.name = "underlay-bounds",
       .kind = kText,
       .value = "X0,Y0,X1,Y1",
       .help = "its lower left and upper right corners [m]; if not given, a picture covers the "
               "case",
       .beside = "underlay"},
      {.name = "sight",
       .kind = kChoice,
       .value = "FILE",
       .help = "table of all sight lines: auto: sight.csv up to 10 MB, sight.csv.zst above; or "
               "one of them, or none",
       .initial = "auto",
       .choices = {"auto", "none", "csv", "csv.zst"}},
      {.name = "pdf",
       .help = "also print the report to report.pdf, by Chromium if it is installed"},
      {.name = "title", .kind = kText, .value = "TEXT", .help = "title of the report"},
      {.name = "project", .kind = kText, .value = "TEXT", .help = "what the report is made for"},
      {.name = "author", .kind = kText, .value = "NAME", .help = "author of the report"},
      {.name = "by", .kind = kText, .value = "NAME", .help = "the same as --author"},
      {.name = "date", .kind = kText, .value = "DATE", .help = "date of the report"},
      {.name = "picture",
       .kind = kText,
       .value = "X,Y,Z",
       .help = "also render pictures from this point towards the nearest sign [m]",
       .several = true},
      {.name = "extinction-limit",
       .kind = kNumber,
       .value = "K",
       .help = "also map when the local extinction reaches K [1/m]",
       .positive = true},
      {.name = "sight-limit",
       .kind = kChoice,
       .value = "NAME",
       .help = "the same, by the name of a rule",
       .choices = sightLimitNames()}};
  options.push_back(statsOption());
  const auto more = mediumOptions(FieldUse::kMeasured);
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace

Command visibilityCommand() {
  return {
      .name = "visibility",
      .summary = "Computes from where, and how long, signs are visible through smoke",
      .examples = {"volute visibility corridor.smv --signs signs.json --height 2 -o visibility",
                   "volute visibility hall.pvd --quantity soot-density --unit g/m3 --signs "
                   "signs.json --route routes.csv --speed 1.2 -o routes",
                   "volute visibility hall.pvd --quantity extinction --signs signs.json --eyes "
                   "eyes.csv -o points"},
      .description =
          "For every eye, sign and stored time: is the sight line blocked, and how much smoke is "
          "on it? Its optical depth is integrated exactly; a sign is visible from its front while "
          "the optical depth is at most C (3 for reflecting signs, 8 for light-emitting "
          "ones).\n\nFOLDER gets sight.csv (one row per eye, sign and time), visibility.json, and "
          "for plans and routes report.html, maps (.png, .vti) and a map of the time at which no "
          "sign is visible any more. docs/visibility.md explains what is computed, and what the "
          "rules leave out.",
      .positionals = {{.name = "CASE",
                       .help = "smoke on a mesh (.vtu, .pvd), an FDS case (.smv), a scene (.json) "
                               "or any other medium"}},
      .options = visibilityOptionTable(),
      .oneOf = {{.names = {"route", "eyes", "trajectories"}},
                {.names = {"author", "by"}},
                {.names = {"extinction-limit", "sight-limit"}}},
      .ranks = true,
      .run = runVisibility};
}

}  // namespace volute::cli
