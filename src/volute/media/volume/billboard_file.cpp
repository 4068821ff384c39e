// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/billboard_file.hpp"

#include "volute/io/json_members.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

Status parseBillboardSize(const Members& members, const std::string& file, BillboardOptions& options) {
  const Json size = members.has("size") ? members.at("size") : Json();
  if (!size.is_array() || size.size() != 2)
    return fail(ErrorCode::kInvalidData, "{}: {}: expected [width, height] [m]", file,
                members.where("size"));
  VOLUTE_ASSIGN(options.width, jsonToNumber(size[0], file, members.where("size") + "[0]"));
  VOLUTE_ASSIGN(options.height, jsonToNumber(size[1], file, members.where("size") + "[1]"));
  if (options.width > 0 && options.height > 0)
    return {};
  return fail(ErrorCode::kInvalidData, "{}: {}: expected two numbers of more than 0 [m]", file,
              members.where("size"));
}

Status parseAlpha(const Members& members, const std::string& file, BillboardOptions& options) {
  if (!members.has("alpha"))
    return {};
  std::string alpha;
  VOLUTE_TRY(members.text("alpha", alpha, "\"transmittance\" or \"intensity\""));
  if (alpha != "transmittance" && alpha != "intensity") {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: '{}' is unknown; expected transmittance or intensity", file,
                members.where("alpha"), alpha);
  }
  options.alpha =
      alpha == "intensity" ? BillboardAlpha::kIntensity : BillboardAlpha::kTransmittance;
  return {};
}

}  // namespace

Result<SceneBillboard> parseBillboard(const Json& json, const std::string& file,
                                      const std::string& path) {
  constexpr std::string_view kNames[] = {"volume",   "position",   "size", "alpha",
                                         "emission", "extinction", "time", "rows"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  SceneBillboard board;
  VOLUTE_TRY(members.text("volume", board.file, "the name of a volume"));
  board.file = besides(file, board.file);
  if (!members.has("position"))
    return fail(ErrorCode::kInvalidData, "{}: {}: is missing; expected three numbers [m]", file,
                members.where("position"));
  VOLUTE_TRY(members.vector("position", board.options.position));
  VOLUTE_TRY(parseBillboardSize(members, file, board.options));
  VOLUTE_TRY(parseAlpha(members, file, board.options));
  VOLUTE_TRY(members.number("emission", board.appearance.emission));
  VOLUTE_TRY(members.number("extinction", board.appearance.extinction));
  VOLUTE_TRY(members.integer("rows", board.options.rows, 1, 4096));
  if (members.has("time")) {
    VOLUTE_ASSIGN(board.appearance.clock,
                  parseClock(members.at("time"), file, members.where("time")));
  }
  return board;
}

}  // namespace volute
