// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

// Writes small FDS cases, as FDS would: those of tests, and what is synthesized. It shares no code
// with the reader.

namespace volute::fdswriter {

using Planes = std::array<std::vector<double>, 3>;
using Function = std::function<double(double x, double y, double z)>;

/// A Fortran file in the making, which remembers where its markers and headers are.
struct Records {
  std::vector<std::uint8_t> bytes;
  std::vector<std::pair<std::size_t, std::size_t>>
      guarded;            ///< [begin, end) of markers and headers
  std::size_t split = 0;  ///< records longer than this are split; 0: never

  void record(const void* data, std::size_t size, bool header);

  template <class T>
  void values(const std::vector<T>& all, bool header = false) {
    record(all.data(), all.size() * sizeof(T), header);
  }

  void label(std::string text);

  void time(float seconds) { record(&seconds, sizeof(seconds), false); }

  void save(const std::filesystem::path& path) const;
};

/// Nodes of a mesh, i2 inclusive.
struct Indices {
  int i1, i2, j1, j2, k1, k2;
};

/// 255, value, count for more than three equal bytes; others as they are.
std::vector<std::uint8_t> runLengths(const std::vector<std::uint8_t>& bytes);

struct Slice {
  Indices at;
  std::string quantity = "SOOT EXTINCTION COEFFICIENT";
  std::string shortName = "ext_coef_Soot";
  std::string unit = "1/m";
};

Records sliceFile(const Slice& slice,
                  const std::vector<std::pair<float, std::vector<float>>>& frames,
                  std::size_t split = 0);
/// `cells` is IBAR, JBAR, KBAR.
Records smokeFile(std::array<int, 3> cells,
                  const std::vector<std::pair<float, std::vector<std::uint8_t>>>& frames,
                  std::size_t split = 0);
Records smoke16File(std::array<int, 3> cells,
                    const std::vector<std::pair<float, std::vector<double>>>& frames,
                    std::size_t split = 0);
Records plotFile(std::array<int, 3> cells, const std::vector<float>& fiveVariables);

/// Walls made of triangles (.ge) that stay, and none that moves.
/// @param corners  three of each triangle, from 1
Records geometryFile(const std::vector<float>& vertices, const std::vector<std::int32_t>& corners,
                     const std::vector<std::int32_t>& surfaces);
/// A closed box of 12 triangles, facing outwards.
Records boxGeometry(std::array<float, 3> min, std::array<float, 3> max, std::int32_t surface);

/// Triangles with their levels' numbers, from 1, at a time.
struct Triangles {
  float time = 0;
  std::vector<float> vertices;                ///< x, y, z of each
  std::vector<std::int32_t> corners, levels;  ///< three corners a triangle, from 1
};

Records isoFile(const std::vector<float>& levels, const std::vector<Triangles>& frames,
                std::size_t split = 0);

/// Particles of some classes, and what the file stores of each class.
struct Particles {
  struct OfAClass {
    std::vector<float> places;  ///< all x, all y, all z
    std::vector<float> values;  ///< of each quantity, one a particle
    /// Of people of FDS+Evac: all angles, diameters, diameters of torsos, heights; and who they
    /// are.
    std::vector<float> bodies{};
    std::vector<std::int32_t> numbers{};
  };

  float time = 0;
  std::vector<OfAClass> classes;
};

/// @param quantities  names and units of each class
Records particleFile(const std::vector<std::vector<std::array<std::string, 2>>>& quantities,
                     const std::vector<Particles>& frames, std::size_t split = 0);

/// The text of a .smv file.
struct Index {
  struct Vent {
    Indices at;       ///< flat
    int surface = 1;  ///< 1: the first of `surfaces`
  };

  struct Mesh {
    Planes planes;
    std::vector<Indices> obstructions;
    std::vector<Indices> openings;  ///< OPEN vents
    bool evacuation = false;        ///< of FDS+Evac
    std::vector<Vent> vents{};
    bool closed = false;  ///< FDS's own walls are around it
  };

  std::string version = "FDS6.7.5-0-g71f025606-release";
  std::string title = "made for a test";
  std::string chid = "made";
  std::vector<std::string> surfaces;  ///< besides INERT
  std::string wallColour = "-3   -1  1.0 0.5 0.25 1.0";
  std::vector<Mesh> meshes;
  std::string files;  ///< what comes after the meshes
  std::string input;  ///< INPF; empty: it is not named

  void slice(int mesh, const Slice& slice, const std::string& file, bool cellCentred);
  void smoke(int mesh, const std::string& file, double massExtinction);
  void plot(int mesh, double time, const std::string& file, const std::string& secondQuantity);
  /// @param quantity  with the species before it, where the version writes that
  void device(const std::string& label, const std::string& quantity, std::array<double, 3> place);
  void event(const std::string& keyword, int mesh, int number, double time);
  std::string text() const;
  void save(const std::filesystem::path& path) const;
};

/// Values at all nodes of a mesh, x fastest.
std::vector<double> atNodes(const Planes& planes, const Function& function);
/// Of cells i1..i2 and so on as FDS counts them: cell i lies between nodes i - 1 and i; what lies
/// outside of the mesh (0) is `ghost`.
std::vector<float> inCells(const Planes& planes, const Indices& at, const Function& function,
                           float ghost);
std::vector<float> atNodes(const Planes& planes, const Indices& at, const Function& function);

void saveText(const std::filesystem::path& path, const std::string& text);
void saveBytes(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes);

}  // namespace volute::fdswriter
