// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_writer.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace volute::fdswriter {
namespace {

void append(std::vector<std::uint8_t>& bytes, const void* data, std::size_t size) {
  const auto* begin = static_cast<const std::uint8_t*>(data);
  bytes.insert(bytes.end(), begin, begin + size);
}

}  // namespace

void Records::record(const void* data, std::size_t size, bool header) {
  const auto* from = static_cast<const std::uint8_t*>(data);
  const std::size_t piece = split == 0 ? size : split;
  for (std::size_t done = 0; done < size || done == 0;) {
    const std::size_t now = std::min(piece, size - done);
    const bool more = done + now < size;
    const auto leading = static_cast<std::int32_t>(more ? -static_cast<std::int64_t>(now) : now);
    const auto trailing =
        static_cast<std::int32_t>(done > 0 ? -static_cast<std::int64_t>(now) : now);
    const std::size_t begin = bytes.size();
    append(bytes, &leading, 4);
    append(bytes, from + done, now);
    append(bytes, &trailing, 4);
    if (header) {
      guarded.emplace_back(begin, bytes.size());
    } else {
      guarded.emplace_back(begin, begin + 4);
      guarded.emplace_back(bytes.size() - 4, bytes.size());
    }
    done += now;
    if (now == 0)
      break;
  }
}

void Records::label(std::string text) {
  text.resize(30, ' ');
  record(text.data(), text.size(), true);
}

void Records::save(const std::filesystem::path& path) const {
  saveBytes(path, bytes);
}

std::vector<std::uint8_t> runLengths(const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> out;
  for (std::size_t i = 0; i < bytes.size();) {
    std::size_t run = 1;
    while (i + run < bytes.size() && bytes[i + run] == bytes[i] && run < 254) ++run;
    if (run > 3) {
      out.insert(out.end(), {255, bytes[i], static_cast<std::uint8_t>(run)});
    } else {
      out.insert(out.end(), run, bytes[i]);
    }
    i += run;
  }
  return out;
}

Records sliceFile(const Slice& slice,
                  const std::vector<std::pair<float, std::vector<float>>>& frames,
                  std::size_t split) {
  Records file;
  file.label(slice.quantity);
  file.label(slice.shortName);
  file.label(slice.unit);
  const Indices& at = slice.at;
  file.values<std::int32_t>({at.i1, at.i2, at.j1, at.j2, at.k1, at.k2}, true);
  file.split = split;
  for (const auto& [time, values] : frames) {
    file.time(time);
    file.values(values);
  }
  return file;
}

Records smokeFile(std::array<int, 3> cells,
                  const std::vector<std::pair<float, std::vector<std::uint8_t>>>& frames,
                  std::size_t split) {
  Records file;
  file.values<std::int32_t>({1, 0, 0, cells[0], 0, cells[1], 0, cells[2]}, true);
  file.split = split;
  for (const auto& [time, bytes] : frames) {
    const auto code = runLengths(bytes);
    file.time(time);
    file.values<std::int32_t>(
        {static_cast<std::int32_t>(bytes.size()), static_cast<std::int32_t>(code.size())}, true);
    file.values(code);
  }
  return file;
}

Records smoke16File(std::array<int, 3> cells,
                    const std::vector<std::pair<float, std::vector<double>>>& frames,
                    std::size_t split) {
  Records file;
  file.values<std::int32_t>({1, 1, 0, cells[0] + 1, cells[1] + 1, cells[2] + 1}, true);
  file.split = split;
  for (const auto& [time, values] : frames) {
    const float least = static_cast<float>(*std::min_element(values.begin(), values.end()));
    float most = static_cast<float>(*std::max_element(values.begin(), values.end()));
    if (most == least)
      most = least + 1;
    std::vector<std::uint8_t> head;
    const auto count = static_cast<std::int32_t>(values.size());
    append(head, &count, 4);
    append(head, &count, 4);
    append(head, &least, 4);
    append(head, &most, 4);
    std::vector<std::uint8_t> words;
    for (const double value : values) {
      const float word = 65535 * (static_cast<float>(value) - least) / (most - least);
      const auto cut = static_cast<unsigned>(std::clamp(word, 0.0F, 65535.0F));
      words.push_back(static_cast<std::uint8_t>(cut >> 8));
      words.push_back(static_cast<std::uint8_t>(cut & 255));
    }
    file.time(time);
    file.values(head);
    if (split == 0)
      file.guarded.emplace_back(file.bytes.size() - 20, file.bytes.size() - 12);  // the counts
    file.values(words);
  }
  return file;
}

Records geometryFile(const std::vector<float>& vertices, const std::vector<std::int32_t>& corners,
                     const std::vector<std::int32_t>& surfaces) {
  using Words = std::vector<std::int32_t>;
  Records file;
  file.values(Words{1}, true);
  file.values(Words{2}, true);
  file.values(Words{0, 0, 1}, true);
  file.time(0);
  file.values(Words{static_cast<std::int32_t>(vertices.size() / 3),
                    static_cast<std::int32_t>(surfaces.size()), 0});
  if (!vertices.empty())
    file.values(vertices);
  if (!surfaces.empty()) {
    file.values(corners);
    file.values(surfaces);
    file.values(std::vector<float>(6 * surfaces.size(), 0));
  }
  file.time(0);
  file.values(Words{0, 0, 0});
  return file;
}

Records boxGeometry(std::array<float, 3> min, std::array<float, 3> max, std::int32_t surface) {
  std::vector<float> vertices;
  for (int i = 0; i < 8; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      vertices.push_back((i >> axis & 1) != 0 ? max[axis] : min[axis]);
  }
  return geometryFile(vertices, {1, 5, 7, 1, 7, 3, 2, 4, 8, 2, 8, 6, 1, 2, 6, 1, 6, 5,
                                 3, 7, 8, 3, 8, 4, 1, 3, 4, 1, 4, 2, 5, 6, 8, 5, 8, 7},
                      std::vector<std::int32_t>(12, surface));
}

Records isoFile(const std::vector<float>& levels, const std::vector<Triangles>& frames,
                std::size_t split) {
  using Words = std::vector<std::int32_t>;
  Records file;
  file.split = split;
  file.values(Words{1}, true);
  file.values(Words{1}, true);
  file.values(Words{static_cast<std::int32_t>(levels.size())}, true);
  file.values(levels);
  file.values(Words{0}, true);
  file.values(Words{0, 0}, true);
  for (const Triangles& frame : frames) {
    file.values(std::vector<float>{frame.time, 0});
    file.values(Words{static_cast<std::int32_t>(frame.vertices.size() / 3),
                      static_cast<std::int32_t>(frame.levels.size())},
                true);
    if (!frame.vertices.empty())
      file.values(frame.vertices);
    if (frame.levels.empty())
      continue;
    file.values(frame.corners);
    file.values(frame.levels);
  }
  return file;
}

Records particleFile(const std::vector<std::vector<std::array<std::string, 2>>>& quantities,
                     const std::vector<Particles>& frames, std::size_t split) {
  using Words = std::vector<std::int32_t>;
  Records file;
  file.split = split;
  file.values(Words{1}, true);
  file.values(Words{600});
  file.values(Words{static_cast<std::int32_t>(quantities.size())}, true);
  for (const auto& ofAClass : quantities) {
    file.values(Words{static_cast<std::int32_t>(ofAClass.size()), 0});
    for (const auto& labels : ofAClass) {
      for (std::string label : labels) {
        label.resize(30, ' ');
        file.record(label.data(), label.size(), false);
      }
    }
  }
  for (const Particles& frame : frames) {
    file.time(frame.time);
    for (std::size_t i = 0; i < quantities.size(); ++i) {
      const auto& one = frame.classes[i];
      const auto count = static_cast<std::int32_t>(one.places.size() / 3);
      file.values(Words{count}, true);
      std::vector<float> places = one.places;
      places.insert(places.end(), one.bodies.begin(), one.bodies.end());
      file.values(places);
      file.values(one.numbers.empty() ? Words(static_cast<std::size_t>(count), 7) : one.numbers);
      if (!quantities[i].empty())
        file.values(one.values);
    }
  }
  return file;
}

Records plotFile(std::array<int, 3> cells, const std::vector<float>& fiveVariables) {
  Records file;
  file.values<std::int32_t>({cells[0] + 1, cells[1] + 1, cells[2] + 1}, true);
  file.values<float>({0, 0, 0, 0}, true);
  file.values(fiveVariables);
  return file;
}

void Index::slice(int mesh, const Slice& slice, const std::string& file, bool cellCentred) {
  const Indices& at = slice.at;
  files += fmt::format(
      "{}{:6} # STRUCTURED %slcf & {:5} {:5} {:5} {:5} {:5} {:5} ! 1 0\n {}\n {}\n {}\n {}\n",
      cellCentred ? "SLCC" : "SLCF", mesh, at.i1, at.i2, at.j1, at.j2, at.k1, at.k2, file,
      slice.quantity, slice.shortName, slice.unit);
}

void Index::smoke(int mesh, const std::string& file, double massExtinction) {
  files += fmt::format("SMOKF3D{:6} {:10.3f}\n {}\n SOOT DENSITY\n rho_Soot\n kg/m3\n", mesh,
                       massExtinction, file);
}

void Index::plot(int mesh, double time, const std::string& file,
                 const std::string& secondQuantity) {
  files += fmt::format("PL3D {:11.2f}{:6}\n {}\n", time, mesh, file);
  for (int i = 0; i < 5; ++i) {
    files += i == 1 ? fmt::format(" {}\n ext\n 1/m\n", secondQuantity)
                    : std::string(" TEMPERATURE\n temp\n C\n");
  }
}

void Index::device(const std::string& label, const std::string& quantity,
                   std::array<double, 3> place) {
  files += fmt::format("DEVICE\n {} % {}\n {:.5f} {:.5f} {:.5f} 0 0 -1 0 0 % null\n", label,
                       quantity, place[0], place[1], place[2]);
}

void Index::event(const std::string& keyword, int mesh, int number, double time) {
  files += fmt::format("{}{:6}\n{:6}{:10.2f}\n", keyword, mesh, number, time);
}

std::string Index::text() const {
  std::string out = fmt::format(
      "TITLE\n {}\n\nFDSVERSION\n{}\n\nCHID\n {}\n\nNMESHES\n {}\n\nALBEDO\n 0.3\n\n"
      "SURFACE\n INERT\n 5000.00 1.00\n 0 1.0 1.0 1.0 0.8 0.4 1.0\n null\n\n",
      title, version, chid, meshes.size());
  for (const std::string& surface : surfaces)
    out +=
        fmt::format("SURFACE\n {}\n 5000.00 1.00\n 0 1.0 1.0 1.0 0.2 0.1 1.0\n null\n\n", surface);
  if (!input.empty())
    out += fmt::format("INPF\n {}\n\n", input);
  for (const Mesh& mesh : meshes) {
    const auto& p = mesh.planes;
    out += fmt::format("OFFSET\n 0.0 0.0 0.0\n\nGRID   mesh\n {:5}{:5}{:5}{:5}\n\n",
                       p[0].size() - 1, p[1].size() - 1, p[2].size() - 1, mesh.evacuation ? 1 : 0);
    out += fmt::format("PDIM\n {:.5f} {:.5f} {:.5f} {:.5f} {:.5f} {:.5f} 0.0 0.0 0.0\n\n",
                       p[0].front(), p[0].back(), p[1].front(), p[1].back(), p[2].front(),
                       p[2].back());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out += fmt::format("TRN{}\n    0\n", "XYZ"[axis]);
      for (std::size_t i = 0; i < p[axis].size(); ++i)
        out += fmt::format("{:5} {:14.5f}\n", i, p[axis][i]);
      out += "\n";
    }
    out += fmt::format("OBST\n {}\n", mesh.obstructions.size());
    int ordinal = 0;
    for (const Indices& o : mesh.obstructions) {
      out += fmt::format("  {:.5f} {:.5f} {:.5f} {:.5f} {:.5f} {:.5f} {} 0 0 0 0 0 0 ! wall\n",
                         p[0][o.i1], p[0][o.i2], p[1][o.j1], p[1][o.j2], p[2][o.k1], p[2][o.k2],
                         ++ordinal);
    }
    for (const Indices& o : mesh.obstructions) {
      out += fmt::format("{:5}{:5}{:5}{:5}{:5}{:5}   {}\n", o.i1, o.i2, o.j1, o.j2, o.k1, o.k2,
                         wallColour);
    }
    const int x = static_cast<int>(p[0].size()) - 1, y = static_cast<int>(p[1].size()) - 1,
              z = static_cast<int>(p[2].size()) - 1;
    std::vector<Vent> vents = mesh.vents;
    if (mesh.closed) {
      for (const Indices& side : {Indices{0, 0, 0, y, 0, z},
                                  {x, x, 0, y, 0, z},
                                  {0, x, 0, 0, 0, z},
                                  {0, x, y, y, 0, z},
                                  {0, x, 0, y, 0, 0},
                                  {0, x, 0, y, z, z}})
        vents.push_back({side, 0});
    }
    out +=
        fmt::format("\nVENT\n {} {}\n", mesh.openings.size() + vents.size(), mesh.closed ? 6 : 0);
    for (std::size_t i = 0; i < mesh.openings.size(); ++i)
      out += fmt::format("  0.0 0.0 0.0 0.0 0.0 0.0 {} 2\n", i + 1);
    for (const Vent& v : vents) {
      out += fmt::format("  {:.5f} {:.5f} {:.5f} {:.5f} {:.5f} {:.5f} {} {}\n", p[0][v.at.i1],
                         p[0][v.at.i2], p[1][v.at.j1], p[1][v.at.j2], p[2][v.at.k1], p[2][v.at.k2],
                         100, v.surface);
    }
    for (const Indices& v : mesh.openings) {
      out +=
          fmt::format("{:5}{:5}{:5}{:5}{:5}{:5}  -99    2\n", v.i1, v.i2, v.j1, v.j2, v.k1, v.k2);
    }
    for (const auto& [v, surface] : vents)
      out +=
          fmt::format("{:5}{:5}{:5}{:5}{:5}{:5}   99    0\n", v.i1, v.i2, v.j1, v.j2, v.k1, v.k2);
    out += "\nCVENT\n    0\n\n";
  }
  return out + files;
}

void Index::save(const std::filesystem::path& path) const {
  saveText(path, text());
}

std::vector<double> atNodes(const Planes& planes, const Function& function) {
  std::vector<double> out;
  for (const double z : planes[2]) {
    for (const double y : planes[1]) {
      for (const double x : planes[0]) out.push_back(function(x, y, z));
    }
  }
  return out;
}

std::vector<float> atNodes(const Planes& planes, const Indices& at, const Function& function) {
  std::vector<float> out;
  for (int k = at.k1; k <= at.k2; ++k) {
    for (int j = at.j1; j <= at.j2; ++j) {
      for (int i = at.i1; i <= at.i2; ++i)
        out.push_back(static_cast<float>(function(planes[0][i], planes[1][j], planes[2][k])));
    }
  }
  return out;
}

std::vector<float> inCells(const Planes& planes, const Indices& at, const Function& function,
                           float ghost) {
  std::vector<float> out;
  for (int k = at.k1; k <= at.k2; ++k) {
    for (int j = at.j1; j <= at.j2; ++j) {
      for (int i = at.i1; i <= at.i2; ++i) {
        out.push_back(i == 0 || j == 0 || k == 0
                          ? ghost
                          : static_cast<float>(function(0.5 * (planes[0][i - 1] + planes[0][i]),
                                                        0.5 * (planes[1][j - 1] + planes[1][j]),
                                                        0.5 * (planes[2][k - 1] + planes[2][k]))));
      }
    }
  }
  return out;
}

void saveText(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary) << text;
}

void saveBytes(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  std::filesystem::remove(path);  // a file that is cut and written again is flushed
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

}  // namespace volute::fdswriter
