// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

#include "volute/base/progress.hpp"
#include "volute/base/team.hpp"
#include "volute/film/film_job.hpp"
#include "volute/film/picture_writer.hpp"

namespace volute {

/// Renders and writes every frame of a job; settles the exposure first when it is to be found
/// (0). A picture is a unit of work: ranks write their image files themselves, and send pictures of
/// a film to rank 0, which writes them in order and holds a few at most. Collective.
/// @param development  in it the exposure that was found
/// @param maxMemory  [bytes]
[[nodiscard]] Status writeFilm(FilmJob& job, const std::string& target, Development& development,
                               std::uint64_t maxMemory, Progress& progress, Team& team);

/// The exposure of a job's pictures where none was asked for: 1 where their light is measured or
/// has a scale, else one for all, from some of them; of a colour map that with which none is beyond
/// it.
[[nodiscard]] Result<double> usualExposure(FilmJob& job, const Development& how,
                                           Progress& progress);

/// FilmJob::stats() of all ranks together. Collective.
[[nodiscard]] Result<nlohmann::ordered_json> sumOfFilmStats(const FilmJob& job, Team& team);

}  // namespace volute
