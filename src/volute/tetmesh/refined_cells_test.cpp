// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Cells whose faces are met by several finer ones: what local refinement leaves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "volute/tetmesh/split_cells.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using Point = std::array<int, 3>;

double linear(const Vec3& at) {
  return 1 + at.dot(Vec3(2, 3, 5));
}

/// Cells of a lattice on which a coarse cell is a cube of edge 2. Vertices are numbered at random.
class LatticeCells {
 public:
  void hexahedron(const Point& low, int edge) {
    std::vector<Point> cell;
    for (const Point& c : {Point{0, 0, 0},
                           {1, 0, 0},
                           {1, 1, 0},
                           {0, 1, 0},
                           {0, 0, 1},
                           {1, 0, 1},
                           {1, 1, 1},
                           {0, 1, 1}})
      cell.push_back({low[0] + edge * c[0], low[1] + edge * c[1], low[2] + edge * c[2]});
    cells_.push_back({CellShape::kHexahedron, {cell}});
  }

  /// A coarse cell. `fine(side)` says whether four faces meet it at a side (x low, x high, y ...),
  /// `halved(middle)` whether an edge with this middle has a vertex there.
  void coarse(const Point& low, const std::function<bool(int)>& fine,
              const std::function<bool(const Point&)>& halved) {
    std::vector<std::vector<Point>> faces;
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto at = [&](int a, int b) {
        Point p = low;
        p[static_cast<std::size_t>(axis)] += side % 2 * 2;
        p[static_cast<std::size_t>(u)] += a;
        p[static_cast<std::size_t>(v)] += b;
        return p;
      };
      if (fine(side)) {
        for (const auto& [a, b] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}})
          faces.push_back({at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)});
        continue;
      }
      auto& face = faces.emplace_back();
      const Point round[8] = {at(0, 0), at(1, 0), at(2, 0), at(2, 1),
                              at(2, 2), at(1, 2), at(0, 2), at(0, 1)};
      for (int i = 0; i < 8; ++i) {
        if (i % 2 == 0 || halved(round[i]))
          face.push_back(round[i]);
      }
    }
    cells_.push_back({CellShape::kPolyhedron, faces});
  }

  CellSoup soup(std::mt19937& random, const std::function<Vec3(const Vec3&)>& warp = {}) const {
    std::map<Point, std::int64_t> numbers;
    for (const auto& [shape, faces] : cells_) {
      for (const auto& face : faces) {
        for (const Point& point : face) numbers.emplace(point, 0);
      }
    }
    std::vector<std::int64_t> order(numbers.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::shuffle(order, random);
    CellSoup soup;
    soup.vertices.resize(numbers.size());
    std::size_t next = 0;
    for (auto& [point, number] : numbers) {
      number = order[next++];
      const Vec3 place(point[0], point[1], point[2]);
      soup.vertices[static_cast<std::size_t>(number)] = warp ? warp(place) : place;
    }
    soup.offsets = {0};
    for (const auto& [shape, faces] : cells_) {
      soup.shapes.push_back(shape);
      auto& out = soup.connectivity;
      if (shape == CellShape::kPolyhedron)
        out.push_back(static_cast<std::int64_t>(faces.size()));
      for (auto face : faces) {
        if (shape == CellShape::kPolyhedron) {
          out.push_back(static_cast<std::int64_t>(face.size()));
          // Files do not care where a face begins and which way it goes.
          std::ranges::rotate(face, face.begin() + static_cast<int>(random() % face.size()));
          if (random() % 2)
            std::ranges::reverse(face);
        }
        for (const Point& point : face) out.push_back(numbers.at(point));
      }
      soup.offsets.push_back(static_cast<std::int64_t>(out.size()));
    }
    return soup;
  }

 private:
  struct Cell {
    CellShape shape;
    std::vector<std::vector<Point>> faces;
  };

  std::vector<Cell> cells_;
};

double sixVolumes(const std::vector<Vec3>& at, const Tet& t) {
  const auto p = [&](int k) {
    return at[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])];
  };
  return std::abs((p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)));
}

/// A mesh of whole tets: of the volume that is wanted for each cell (0: any), closed but for
/// triangles on its bounds, and a linear field is itself at the added vertices.
void expectSound(const CellSoup& soup, const std::vector<double>& volumes, bool box) {
  const auto split = splitCells(soup, "cells");
  ASSERT_TRUE(split.has_value()) << split.error().message;
  const std::vector<Vec3> vertices = split->vertices(soup);
  std::vector<double> found(soup.shapes.size(), 0);
  for (std::size_t t = 0; t < split->tets.size(); ++t) {
    const double six = sixVolumes(vertices, split->tets[t]);
    found[static_cast<std::size_t>(split->cellOf[t])] += six / 6;
    EXPECT_GT(six, 1e-3);  // of a coarse cell's 48
  }
  for (std::size_t i = 0; i < volumes.size(); ++i) EXPECT_NEAR(found[i], volumes[i], 1e-9) << i;
  const auto mesh = TetMesh::build(vertices, split->tets, "cells");
  ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
  for (const std::int32_t f : (*mesh)->boundary()) {
    const auto& corners = (*mesh)->faces()[static_cast<std::size_t>(f)].vertices;
    bool outside = !box;
    for (int axis = 0; axis < 3 && box; ++axis) {
      for (const double wall : {(*mesh)->bounds().min[axis], (*mesh)->bounds().max[axis]}) {
        outside = outside || std::ranges::all_of(corners, [&](std::int32_t v) {
                    return vertices[static_cast<std::size_t>(v)][axis] == wall;
                  });
      }
    }
    EXPECT_TRUE(outside);
  }
  std::vector<float> values;
  for (const Vec3& at : soup.vertices) values.push_back(static_cast<float>(linear(at)));
  values = split->added.follow(values);
  ASSERT_EQ(values.size(), vertices.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_NEAR(values[i], linear(vertices[i]), 2e-6 * linear(vertices[i]));
}

TEST(RefinedCells, AHexahedronWithAnySidesInFour) {
  std::mt19937 random(3);
  for (int sides = 0; sides < 64; ++sides) {
    LatticeCells cells;
    const auto fine = [&](int side) { return (sides >> side & 1) != 0; };
    const auto halved = [&](const Point& middle) {
      for (int side = 0; side < 6; ++side) {
        if (fine(side) && middle[static_cast<std::size_t>(side / 2)] == side % 2 * 2)
          return true;
      }
      return false;
    };
    cells.coarse({0, 0, 0}, fine, halved);
    for (int numbering = 0; numbering < 40; ++numbering) {
      expectSound(cells.soup(random), {8}, true);
      if (HasFailure())
        FAIL() << "sides " << sides << ", numbering " << numbering;
    }
  }
}

/// 3^3 coarse cells of which some are eight fine ones.
/// `named`: all faces name the vertices on their edges.
LatticeCells refined(std::mt19937& random, std::vector<double>& volumes, bool named = true) {
  constexpr int kCells = 3;
  std::set<Point> fine;
  const auto share = random() % 4 + 1;
  for (int i = 0; i < kCells * kCells * kCells; ++i) {
    if (random() % 5 < share)
      fine.insert({i % kCells, i / kCells % kCells, i / kCells / kCells});
  }
  LatticeCells cells;
  for (int i = 0; i < kCells * kCells * kCells; ++i) {
    const Point cell{i % kCells, i / kCells % kCells, i / kCells / kCells};
    const Point low{2 * cell[0], 2 * cell[1], 2 * cell[2]};
    if (fine.contains(cell)) {
      for (int k = 0; k < 8; ++k) {
        cells.hexahedron({low[0] + k % 2, low[1] + k / 2 % 2, low[2] + k / 4}, 1);
        volumes.push_back(1);
      }
      continue;
    }
    cells.coarse(
        low,
        [&](int side) {
          Point beside = cell;
          beside[static_cast<std::size_t>(side / 2)] += side % 2 * 2 - 1;
          return fine.contains(beside);
        },
        [&](const Point& middle) {
          return named && std::ranges::any_of(fine, [&](const Point& f) {
                   for (std::size_t k = 0; k < 3; ++k) {
                     if (middle[k] < 2 * f[k] || middle[k] > 2 * f[k] + 2)
                       return false;
                   }
                   return true;
                 });
        });
    volumes.push_back(8);
  }
  return cells;
}

TEST(RefinedCells, MeetTheirNeighboursForEveryNumbering) {
  std::mt19937 random(8);
  for (int round = 0; round < 150; ++round) {
    std::vector<double> volumes;
    const LatticeCells cells = refined(random, volumes);
    expectSound(cells.soup(random), volumes, true);
    if (HasFailure())
      FAIL() << "round " << round;
  }
}

TEST(RefinedCells, MeetTheirNeighboursWhereFacesLeaveOutTheVerticesOnTheirEdges) {
  std::mt19937 random(9);
  for (int round = 0; round < 100; ++round) {
    std::vector<double> volumes;
    const LatticeCells cells = refined(random, volumes, false);
    expectSound(cells.soup(random), volumes, true);
    if (HasFailure())
      FAIL() << "round " << round;
  }
}

TEST(RefinedCells, MeetTheirNeighboursWhereFacesAreNotFlat) {
  std::mt19937 random(4);
  const auto warp = [](const Vec3& p) {
    return Vec3(p + 0.1 * Vec3(std::sin(2 * p.y() + p.z()), std::cos(3 * p.x() - p.z()),
                               std::sin(p.x() + 2 * p.y())));
  };
  for (int round = 0; round < 100; ++round) {
    std::vector<double> volumes;
    const LatticeCells cells = refined(random, volumes);
    expectSound(cells.soup(random, warp), {}, false);
    if (HasFailure())
      FAIL() << "round " << round;
  }
}

/// Coordinates in single precision, far from the origin: vertices in the middle of an edge are not
/// on it any more.
TEST(RefinedCells, SurviveSinglePrecision) {
  std::mt19937 random(6);
  const auto round = [](const Vec3& p) {
    const Vec3 place = Vec3(312.7, -87.3, 41.9) + 0.037 * p;
    return Vec3(place.cast<float>().cast<double>());
  };
  for (int i = 0; i < 100; ++i) {
    std::vector<double> volumes;
    const CellSoup soup = refined(random, volumes).soup(random, round);
    const auto split = splitCells(soup, "cells");
    ASSERT_TRUE(split.has_value()) << split.error().message;
    const auto mesh = TetMesh::build(split->vertices(soup), split->tets, "cells");
    ASSERT_TRUE(mesh.has_value()) << mesh.error().message;
    double volume = 0;
    for (std::size_t t = 0; t < split->tets.size(); ++t)
      volume += (*mesh)->volume(static_cast<std::int32_t>(t));
    EXPECT_NEAR(volume / std::pow(6 * 0.037, 3), 1, 2e-3);
  }
}

/// A polyhedron over a polygon in the plane, from z = 0 to 1.
CellSoup prism(const std::vector<Vec3>& round, std::mt19937& random) {
  const std::size_t n = round.size();
  std::vector<std::int64_t> number(2 * n);
  std::iota(number.begin(), number.end(), 0);
  std::ranges::shuffle(number, random);
  CellSoup soup;
  soup.vertices.resize(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    soup.vertices[static_cast<std::size_t>(number[i])] = round[i];
    soup.vertices[static_cast<std::size_t>(number[n + i])] = round[i] + Vec3(0, 0, 1);
  }
  soup.shapes = {CellShape::kPolyhedron};
  auto& out = soup.connectivity;
  out.push_back(static_cast<std::int64_t>(n + 2));
  for (const std::size_t z : {std::size_t{0}, n}) {
    out.push_back(static_cast<std::int64_t>(n));
    for (std::size_t i = 0; i < n; ++i) out.push_back(number[z + i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    out.insert(out.end(), {4, number[i], number[j], number[n + j], number[n + i]});
  }
  soup.offsets = {0, static_cast<std::int64_t>(out.size())};
  return soup;
}

TEST(RefinedCells, NotConvexOnes) {
  std::mt19937 random(2);
  const std::vector<Vec3> corner{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  // Seen whole from the middle of the left side alone, where it has no vertex.
  const std::vector<Vec3> arrow{{0, 0, 0},   {4, 0, 0}, {1, 1.9, 0},
                                {1, 2.1, 0}, {4, 4, 0}, {0, 4, 0}};
  const std::vector<Vec3> hoof{{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0},
                               {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  for (int numbering = 0; numbering < 50; ++numbering) {
    expectSound(prism(corner, random), {3}, false);
    expectSound(prism(arrow, random), {}, false);
    EXPECT_THAT(splitCells(prism(hoof, random), "a.foam").error().message,
                ::testing::AllOf(HasSubstr("a.foam: cell 0 (of 10 faces)"), HasSubstr("mend")));
  }
}

TEST(RefinedCells, SayWhatIsWrong) {
  std::mt19937 random(2);
  const std::vector<Vec3> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  CellSoup soup = prism(square, random);
  const CellSoup whole = soup;
  soup.connectivity.resize(soup.connectivity.size() - 5);  // a side is missing
  soup.connectivity[0] = 5;
  soup.offsets[1] -= 5;
  EXPECT_THAT(splitCells(soup, "a.foam").error().message,
              ::testing::AllOf(HasSubstr("a.foam: cell 0 is not closed"), HasSubstr("1 of its")));
  soup = whole;
  for (Vec3& at : soup.vertices) at.z() = 0;
  EXPECT_THAT(splitCells(soup, "a.foam").error().message, HasSubstr("cell 0 has "));
  soup = whole;
  soup.vertices[3].x() = std::nan("");
  EXPECT_THAT(splitCells(soup, "a.foam").error().message, HasSubstr("vertex 3 is at (nan"));
}

/// Programs that know hexahedra alone write wedges, pyramids and tets as hexahedra with vertices
/// named twice.
TEST(RefinedCells, CollapsedHexahedra) {
  CellSoup soup;
  soup.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0),
                   Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 0, 1)};
  const auto volumeOf = [&](const std::vector<std::int64_t>& cell) {
    soup.shapes = {CellShape::kHexahedron};
    soup.connectivity = cell;
    soup.offsets = {0, 8};
    const auto split = splitCells(soup, "a.e");
    if (!split)
      return -1.0;
    double sum = 0;
    for (const Tet& tet : split->tets) sum += sixVolumes(split->vertices(soup), tet) / 6;
    return sum;
  };
  EXPECT_NEAR(volumeOf({0, 1, 2, 3, 4, 5, 5, 4}), 0.5, 1e-12);      // a wedge
  EXPECT_NEAR(volumeOf({0, 1, 2, 3, 4, 4, 4, 4}), 1.0 / 3, 1e-12);  // a pyramid
  EXPECT_NEAR(volumeOf({0, 1, 2, 2, 4, 4, 4, 4}), 1.0 / 6, 1e-12);  // a tet
  EXPECT_EQ(volumeOf({0, 1, 2, 3, 3, 2, 1, 0}), -1);
}

}  // namespace
}  // namespace volute
