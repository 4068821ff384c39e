// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/surface_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "volute/io/glb_writer.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace testing;

std::string messageOf(const std::filesystem::path& path, std::uint64_t maxMemory = 1 << 28) {
  const auto mesh = readSurfaces(path, maxMemory);
  return mesh ? "" : mesh.error().message;
}

TEST(Obj, ReadsPolygonsMaterialsAndNumbersFromTheEnd) {
  const TempFolder folder;
  writeBytes(folder / "a.mtl",
             "newmtl red\nKd 0.5 0.25 +0.125\nnewmtl lamp # bright\nKd 0 0 0\nKe 3 2 1\n");
  writeBytes(folder / "a.obj",
             "# a wall\nmtllib a.mtl\r\nv 0 0 0\nv 1 0 0\nv 1 1e0 0\nv 0 1 .5 1.0\n"
             "usemtl red\nf 1/1/1 2//3 3/2 4\nusemtl lamp\nf -1 -2 \\\n-3\ns off\nl 1 2\n");
  ASSERT_VALUE(const auto mesh, readSurfaces(folder / "a.obj"));
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[1].corners[2], Vec3(0, 1, 0.5));
  EXPECT_EQ(mesh.triangles[2].corners[0], Vec3(0, 1, 0.5));
  EXPECT_EQ(mesh.triangles[2].corners[2], Vec3(1, 0, 0));
  EXPECT_EQ(mesh.materials[mesh.triangles[0].material].baseColor[2], 0.125);
  EXPECT_EQ(mesh.materials[mesh.triangles[2].material].emission[0], 3);

  // As programs on Windows name it.
  writeBytes(folder / "b.obj",
             "mtllib .\\A.MTL\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl lamp\nf 1 2 3\n");
  ASSERT_VALUE(const auto other, readSurfaces(folder / "b.obj"));
  EXPECT_EQ(other.materials[other.triangles[0].material].emission[0], 3);
}

TEST(Obj, UnknownWordsAreRefused) {
  const TempFolder folder;
  const std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto obj = [&](const std::string& more) {
    writeBytes(folder / "b.obj", faces + more);
    return messageOf(folder / "b.obj");
  };
  const auto mtl = [&](const std::string& text) {
    writeBytes(folder / "b.mtl", text);
    return obj("mtllib b.mtl\n");
  };
  EXPECT_EQ(obj("vt 0 0\nvn 0 0 1\no a\ng b\ns 1\nusemtl x\nl 1 2\np 1\n"), "");
  EXPECT_THAT(obj("w 1 1 1\n"), HasSubstr("b.obj: line 5: 'w' is no statement"));
  EXPECT_THAT(obj("usemtk red\n"), HasSubstr("'usemtk' is no statement; did you mean 'usemtl'?"));
  EXPECT_THAT(obj("call other.obj\n"), HasSubstr("line 5: 'call'"));
  EXPECT_EQ(mtl("newmtl a\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nKe 0 0 0\nNs 1\nNi 1\nd 1\nTr 0\n"
                "Tf 1 1 1\nillum 2\nPr 1\nPm 0\nmap_Kd a.png\nmap_Bump b.png\nnorm c.png\n"
                "interpolateMode NEAREST\n"),
            "");
  EXPECT_THAT(mtl("newmtl a\nKf 1 0 0\n"), HasSubstr("b.mtl: line 2: 'Kf' is no statement"));
  EXPECT_THAT(mtl("newmtl a\nKd 1 0 0\nnewmtl a\nKd 0 1 0\n"),
              HasSubstr("b.mtl: the material 'a' is there twice, with other colors"));
  EXPECT_THAT(mtl("newmtl a\nKd 1 0 0\nKd 0 1 0\n"), HasSubstr("line 3: Kd is there twice"));
  EXPECT_THAT(mtl("newmtl a\nKe 1 0 0 1\n"), HasSubstr("Ke has more than three shares"));
  EXPECT_THAT(obj("surf 0 1 0 1 1 2 3 4\n"), HasSubstr("free-form surfaces are not read"));
  EXPECT_EQ(mtl("\xEF\xBB\xBFnewmtl a\nKd 1 0 0\nnewmtl a\nKd 1 0 0\n"), "");
  EXPECT_THAT(mtl(std::string("\xFF\xFEn\0e\0", 6)), HasSubstr("b.mtl: is text in UTF-16"));
  EXPECT_THAT(mtl("newmtk a\nKd 1 0 0\n"), HasSubstr("did you mean 'newmtl'?"));
}

TEST(Obj, MaterialsMayHaveSpacesInTheirNames) {
  const TempFolder folder;
  writeBytes(folder / "a.mtl", "newmtl red wall\nKd 1 0 0\nnewmtl red floor\nkd 0 1 0\n");
  writeBytes(folder / "a.obj",
             "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red wall\nf 1 2 3\n"
             "usemtl red floor\nf 1 2 3\n");
  ASSERT_VALUE(const auto mesh, readSurfaces(folder / "a.obj"));
  EXPECT_EQ(mesh.materials[mesh.triangles[0].material].baseColor[0], 1);
  EXPECT_EQ(mesh.materials[mesh.triangles[1].material].baseColor[1], 1);
}

TEST(Obj, ColoursOfVerticesAreTold) {
  const TempFolder folder;
  for (const auto& [more, told] : {std::pair("", false), std::pair(" 1", false),
                                   std::pair(" 1 0 0", true), std::pair(" 1 1 0 0", true)}) {
    writeBytes(folder / "a.obj", std::string("v 0 0 0") + more + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    ASSERT_VALUE(const auto mesh, readSurfaces(folder / "a.obj"));
    EXPECT_EQ(mesh.remarks.size(), told ? 1U : 0U) << more;
  }
}

TEST(Obj, WhatIsNotDrawnIsTold) {
  const TempFolder folder;
  const std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const auto remarks = [&](const std::string& obj, const std::string& mtl) {
    writeBytes(folder / "a.mtl", mtl);
    writeBytes(folder / "a.obj", obj + faces);
    const auto mesh = readSurfaces(folder / "a.obj");
    return mesh ? mesh->remarks : std::vector<std::string>{mesh.error().message};
  };
  const std::string plain = "newmtl a\nKd 1 1 1\nd 1\nTr 0\n";
  EXPECT_THAT(
      remarks("# units: metres\n# Units in this file are in m\n# united in 1990\nmtllib a.mtl\n",
              plain),
      IsEmpty());
  EXPECT_THAT(remarks("# File units = millimeters\n", plain),
              ElementsAre(HasSubstr("its unit is millimeters; taken as metres")));
  EXPECT_THAT(remarks("#Unit:cm\n", plain), ElementsAre(HasSubstr("its unit is cm")));
  EXPECT_THAT(remarks("mtllib a.mtl\nusemtl a\n", plain), IsEmpty());
  EXPECT_THAT(remarks("mtllib a.mtl\nusemtl A\n", plain),
              ElementsAre(HasSubstr("'A' is not there")));
  EXPECT_THAT(remarks("mtllib b.mtl\nusemtl a\n", plain),
              ElementsAre(HasSubstr("is in b.mtl, which")));
  EXPECT_THAT(remarks("v 1 1 1\nl 1 2\n", plain), ElementsAre(HasSubstr("lines and curves")));
  EXPECT_THAT(remarks("mtllib a.mtl\n", plain + "newmtl b\nKd 204 51 25\n"),
              ElementsAre(HasSubstr("a surface of Kd 204 51 25 reflects more")));
  EXPECT_THAT(remarks("mtllib a.mtl\nusemtl lamp\n", plain + "newmtl lamp\nKe 1 1 1\n"),
              ElementsAre(HasSubstr("'lamp' has no Kd")));
  EXPECT_THAT(remarks("mtllib a.mtl\n", "Kd 1 0 0\n" + plain),
              ElementsAre(HasSubstr("a.mtl: line 1: Kd is before newmtl")));
  EXPECT_THAT(remarks("mtllib a.mtl\n", plain + "map_Kd wood.png\n"),
              ElementsAre(HasSubstr("map_Kd, map_Ke")));
  EXPECT_THAT(remarks("mtllib a.mtl\n", plain + "newmtl glass\nd 0.3\n"),
              ElementsAre(HasSubstr("drawn opaque")));
}

TEST(Obj, ErrorsNameTheLine) {
  const TempFolder folder;
  const auto message = [&](const std::string& text) {
    writeBytes(folder / "b.obj", text);
    return messageOf(folder / "b.obj");
  };
  EXPECT_THAT(message("v 0 0 0\nv 1 x 0\n"), HasSubstr("b.obj: line 2: 'x'"));
  EXPECT_THAT(message("v 0 0 nan\n"), HasSubstr("line 1"));
  EXPECT_THAT(message("v 0 3 0 junk\n"), HasSubstr("'junk' behind a coordinate"));
  EXPECT_THAT(message("v 0 0 0\nf 1 1 2\n"), HasSubstr("vertex 2 of 1"));
  EXPECT_THAT(message("v 0 0 0\nf 1 1 -2\n"), HasSubstr("vertex -2 of 1"));
  EXPECT_THAT(message("v 0 0 0\nf 1 1\n"), HasSubstr("at least 3"));
  EXPECT_THAT(message("v 0 0 0\nf 1 a 1\n"), HasSubstr("'a'"));
  EXPECT_THAT(message("v 0 0 0\n"), HasSubstr("no faces"));
  EXPECT_THAT(message("mtllib ../secret.mtl\n"), HasSubstr("not below"));
  EXPECT_THAT(messageOf(folder / "none.obj"), HasSubstr("none.obj"));
  EXPECT_THAT(messageOf(folder / "scene.fbx"),
              HasSubstr("expected .glb, .gltf, .obj, .vtp, .vdb or .nvdb"));
  writeBytes(folder / "c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\n");
  EXPECT_THAT(messageOf(folder / "c.obj", 100), HasSubstr("memory"));
}

#if VOLUTE_HAS_GLTF

/// Appends values as they lie in memory.
template <class T>
void append(std::string& bytes, std::initializer_list<T> values) {
  for (const T& value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string glb(std::string json, std::string binary) {
  while (json.size() % 4 != 0) json.push_back(' ');
  while (binary.size() % 4 != 0) binary.push_back('\0');
  std::string bytes = "glTF";
  append<std::uint32_t>(bytes, {2, static_cast<std::uint32_t>(28 + json.size() + binary.size()),
                                static_cast<std::uint32_t>(json.size()), 0x4E4F534A});
  bytes += json;
  append<std::uint32_t>(bytes, {static_cast<std::uint32_t>(binary.size()), 0x004E4942});
  return bytes + binary;
}

/// Four corners of a square and the six numbers of its two triangles.
std::string square() {
  std::string bytes;
  append<float>(bytes, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  append<std::uint16_t>(bytes, {0, 1, 2, 0, 2, 3});
  return bytes;
}

std::string sample(const std::string& nodes, const std::string& primitive = "") {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":)" + nodes +
         R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0)" +
         primitive +
         R"(}]}],"materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0.125,1]},)"
         R"("emissiveFactor":[0,0,1]}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",)"
         R"("min":[0,0,0],"max":[1,1,0]},)"
         R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":48},)"
         R"({"buffer":0,"byteOffset":48,"byteLength":12}],"buffers":[{"byteLength":60}]})";
}

TEST(Gltf, PlacesInstancesByTheirNodes) {
  const TempFolder folder;
  // One mesh twice: moved below a scaled parent, and turned by a quarter about z by a matrix.
  writeBytes(folder / "a.glb",
             glb(sample(R"([{"children":[1,2]},)"
                        R"({"mesh":0,"translation":[10,0,0],"scale":[2,3,1]},)"
                        R"({"mesh":0,"matrix":[0,1,0,0,-1,0,0,0,0,0,1,0,0,0,5,1]}])"),
                 square()));
  ASSERT_VALUE(const auto mesh, readSurfaces(folder / "a.glb"));
  ASSERT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.triangles[0].corners[2], Vec3(12, 3, 0));
  EXPECT_EQ(mesh.triangles[3].corners[1], Vec3(-1, 1, 5));
  EXPECT_EQ(mesh.materials[mesh.triangles[0].material].baseColor[1], 0.25);
  EXPECT_EQ(mesh.materials[mesh.triangles[0].material].emission[2], 1);
}

TEST(Gltf, ReadsStripsAndFansAndBuffersBesideTheFile) {
  const TempFolder folder;
  std::string json = sample(R"([{"mesh":0,"rotation":[0,0,1,0]}])", R"(,"mode":6)");
  json.replace(json.find(R"("byteLength":60)"), 15, R"("byteLength":60,"uri":"b.bin")");
  writeBytes(folder / "b.bin", square());
  writeBytes(folder / "b.gltf", json);
  ASSERT_VALUE(const auto fan, readSurfaces(folder / "b.gltf"));
  ASSERT_EQ(fan.triangles.size(), 4u);
  EXPECT_LT((fan.triangles[0].corners[2] - Vec3(-1, -1, 0)).norm(), 1e-12);  // half a turn
  EXPECT_LT((fan.triangles[3].corners[0] - Vec3::Zero()).norm(), 1e-12);
  writeBytes(folder / "c.glb", glb(sample(R"([{"mesh":0}])", R"(,"mode":5)"), square()));
  ASSERT_VALUE(const auto strip, readSurfaces(folder / "c.glb"));
  EXPECT_EQ(strip.triangles.size(), 4u);
}

TEST(Gltf, WhatIsWrittenIsRead) {
  const TempFolder folder;
  TriangleMesh mesh;
  mesh.materials = {{Rgb(0.5, 0.25, 0.125), Rgb::Zero()}, {}, {Rgb::Zero(), Rgb(4, 2, 0)}};
  for (int i = 0; i < 5; ++i)
    mesh.triangles.push_back(
        {{Vec3(i, 0, 0.5), Vec3(0, i, -1), Vec3(1, 2, i)}, i % 2 == 0 ? 0u : 2u});
  ASSERT_TRUE(writeGlb(folder / "w.glb", mesh));
  ASSERT_VALUE(const auto read, readSurfaces(folder / "w.glb"));
  ASSERT_EQ(read.triangles.size(), 5u);
  EXPECT_EQ(read.triangles[1].corners[0], Vec3(2, 0.5, 0));  // by material, y upwards
  EXPECT_EQ(read.triangles[4].corners[2], Vec3(1, 3, -2));
  EXPECT_EQ(read.materials[read.triangles[0].material].baseColor[1], 0.25);
  EXPECT_NEAR(read.materials[read.triangles[4].material].emission[0], 4, 1e-12);
}

TEST(Gltf, WhatIsNotDrawnIsTold) {
  const TempFolder folder;
  std::string json = sample(R"([{"mesh":0}])");
  writeBytes(folder / "a.glb", glb(json, square()));
  ASSERT_VALUE(const auto plain, readSurfaces(folder / "a.glb"));
  EXPECT_THAT(plain.remarks, IsEmpty());
  json.insert(1, R"("textures":[{"source":0}],"images":[{"uri":"wood.png"}],)");
  json.insert(json.find(R"("emissiveFactor")"), R"("alphaMode":"BLEND",)");
  writeBytes(folder / "a.glb", glb(json, square()));
  ASSERT_VALUE(const auto mesh, readSurfaces(folder / "a.glb"));
  EXPECT_THAT(mesh.remarks, ElementsAre(HasSubstr("textures"), HasSubstr("drawn opaque")));
  json = sample(R"([{"mesh":0}])");
  json.insert(1, R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"point"}]}},)");
  json.insert(json.find(R"("POSITION":0)"), R"("COLOR_0":0,)");
  json.insert(json.find(R"("emissiveFactor")"),
              R"("extensions":{"KHR_materials_transmission":{"transmissionFactor":1}},)");
  writeBytes(folder / "a.glb", glb(json, square()));
  ASSERT_VALUE(const auto more, readSurfaces(folder / "a.glb"));
  EXPECT_THAT(more.remarks,
              ElementsAre(HasSubstr("COLOR_0"), HasSubstr("lights"), HasSubstr("drawn opaque")));
}

TEST(Gltf, WhatTheSceneDoesNotShowIsTold) {
  const TempFolder folder;
  const auto read = [&](const std::string& json) {
    writeBytes(folder / "a.glb", glb(json, square()));
    return readSurfaces(folder / "a.glb");
  };
  // A second node with a mesh that no scene has, and one that is hidden below another.
  std::string json = sample(R"([{"mesh":0},{"mesh":0}])");
  ASSERT_VALUE(const auto apart, read(json));
  EXPECT_THAT(apart.remarks, ElementsAre(HasSubstr("1 of its nodes with meshes are not in it")));
  json = sample(R"([{"mesh":0,"children":[1]},{"children":[2],"extensions":{"KHR_node_visibility":)"
                R"({"visible":false}}},{"mesh":0}])");
  ASSERT_VALUE(const auto hidden, read(json));
  EXPECT_EQ(hidden.triangles.size(), 2U);
  EXPECT_THAT(hidden.remarks, IsEmpty());
  json = sample(R"([{"mesh":0}])");
  json.insert(json.find(R"({"attributes")"), R"({"attributes":{"POSITION":0},"mode":1},)");
  json.insert(1, R"("animations":[{"channels":[],"samplers":[]}],)");
  json.insert(
      json.find(R"("emissiveFactor")"),
      R"("extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[1,0,0,1]}},)");
  ASSERT_VALUE(const auto more, read(json));
  EXPECT_THAT(more.remarks, ElementsAre(HasSubstr("animations"), HasSubstr("points and lines")));
  EXPECT_EQ(more.materials[more.triangles[0].material].baseColor[1], 0);
}

TEST(Gltf, WhatAlphaMasksEverywhereIsNotThere) {
  const TempFolder folder;
  for (const auto& [alpha, there] : {std::pair("0.4", false), std::pair("0.6", true)}) {
    std::string json = sample(R"([{"mesh":0}])");
    json.replace(json.find("0.125,1]") + 6, 1, alpha);
    json.insert(json.find(R"("emissiveFactor")"), R"("alphaMode":"MASK",)");
    writeBytes(folder / "a.glb", glb(json, square()));
    EXPECT_EQ(readSurfaces(folder / "a.glb").has_value(), there) << alpha;
  }
}

TEST(Gltf, ErrorsNameTheElement) {
  const TempFolder folder;
  const auto message = [&](const std::string& json, const std::string& binary) {
    writeBytes(folder / "d.glb", glb(json, binary));
    return messageOf(folder / "d.glb");
  };
  const auto with = [&](const char* from, const char* to) {
    std::string json = sample(R"([{"mesh":0}])");
    json.replace(json.find(from), std::strlen(from), to);
    return message(json, square());
  };
  EXPECT_EQ(message(sample(R"([{"mesh":0}])"), square()), "");
  EXPECT_THAT(with(R"("count":6)", R"("count":9)"), HasSubstr("beyond their buffer"));
  EXPECT_THAT(with(R"("count":4)", R"("count":3)"), HasSubstr("names vertex 3 of 3"));
  EXPECT_THAT(with(R"("mesh":0)", R"("mesh":7)"), HasSubstr("no mesh 7"));
  EXPECT_THAT(with(R"("material":0)", R"("material":9)"), HasSubstr("no material 9"));
  EXPECT_THAT(with(R"("POSITION":0)", R"("POSITION":5)"), HasSubstr("no accessor 5"));
  EXPECT_THAT(with(R"("asset")", R"("extensionsRequired":["EXT_x"],"asset")"), HasSubstr("EXT_x"));
  EXPECT_THAT(message(sample(R"([{"children":[0]}])"), square()), HasSubstr("contain each other"));
  EXPECT_THAT(message(sample(R"([{"children":[3]}])"), square()), HasSubstr("no node 3"));
  EXPECT_THAT(message(sample(R"([{"name":"empty"}])"), square()), HasSubstr("no triangles"));
  EXPECT_THAT(message("{", ""), HasSubstr("d.glb: not a whole glTF"));
  // What would be left out without a word.
  const auto node = [&](const char* members) {
    return message(sample(fmt::format(R"([{{"mesh":0,{}}}])", members)), square());
  };
  EXPECT_EQ(node(R"("translation":[0,1,2])"), "");
  EXPECT_THAT(node(R"("translation":[0,1])"),
              HasSubstr("/nodes/0/translation: expected 3 numbers"));
  EXPECT_THAT(node(R"("translation":[0,1,9.97e36])"), HasSubstr("3 numbers of up to 1e+12"));
  EXPECT_THAT(node(R"("translation_cm":[0,1,2])"), HasSubstr("'translation_cm' is unknown"));
  EXPECT_THAT(node(R"("Scale":[2,2,2])"), HasSubstr("'Scale' is unknown; expected scale"));
  EXPECT_THAT(node(R"("scale":["1","1","1"])"), HasSubstr("/nodes/0/scale: expected 3 numbers"));
  EXPECT_THAT(node(R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0])"),
              HasSubstr("expected 16 numbers"));
  EXPECT_THAT(node(R"("scale":[1,1,1],"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1])"),
              HasSubstr("has both matrix and scale"));
  EXPECT_THAT(node(R"("scale":[1,1,1],"scale":[2,2,2])"), HasSubstr("'scale' is there twice"));
  EXPECT_THAT(node(R"("extensions":{"EXT_mesh_gpu_instancing":{}})"), HasSubstr("instancing"));
  EXPECT_THAT(with(R"("version":"2.0")", R"("version":"1.0")"), HasSubstr("/asset/version is 1.0"));
  EXPECT_THAT(with(R"("version":"2.0")", R"("version":"2.1","minVersion":"2.1")"),
              HasSubstr("/asset/minVersion is 2.1; expected glTF 2.0"));
  EXPECT_EQ(with(R"("version":"2.0")", R"("version":"2.1")"), "");
  EXPECT_THAT(with(R"("baseColorFactor":[)", R"("baseColorFactor":[1,)"),
              HasSubstr("/materials/0/pbrMetallicRoughness/baseColorFactor: expected 4 numbers"));
  std::string outside = sample(R"([{"mesh":0}])");
  outside.replace(outside.find(R"("byteLength":60)"), 15,
                  R"("byteLength":60,"uri":"../../../../etc/hostname")");
  writeBytes(folder / "e.gltf", outside);
  EXPECT_NE(messageOf(folder / "e.gltf"), "");
}

TEST(Gltf, DamageIsAnErrorOrOtherTriangles) {
  const TempFolder folder;
  const std::string whole = glb(sample(R"([{"mesh":0}])"), square());
  const auto read = [](const std::filesystem::path& file) { return readSurfaces(file, 1 << 26); };
  expectCutsRefused(folder / "cut.glb", whole.substr(0, whole.size() - 4), read, 29);
  for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 83) {
    writeBytes(folder / "flip.glb", withFlippedBit(whole, bit));
    const auto mesh = read(folder / "flip.glb");
    if (!mesh) {
      EXPECT_THAT(mesh.error().message, HasSubstr("flip.glb"));
      EXPECT_THAT(mesh.error().message, ::testing::Not(HasSubstr("signal")));
      continue;
    }
    for (const Triangle& triangle : mesh->triangles) {
      ASSERT_LT(triangle.material, mesh->materials.size());
      for (const Vec3& corner : triangle.corners) ASSERT_TRUE(corner.allFinite());
    }
  }
}

#else

TEST(Gltf, SaysThatThisBuildHasNone) {
  const TempFolder folder;
  writeBytes(folder / "a.glb", "glTF");
  EXPECT_THAT(messageOf(folder / "a.glb"), HasSubstr("VOLUTE_WITH_GLTF"));
}

#endif

#if VOLUTE_HAS_VTK

/// A triangle, a hollow pentagon and a strip.
std::string vtp(const std::string& strip) {
  return R"(<?xml version="1.0"?>
<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>
<Piece NumberOfPoints="5" NumberOfPolys="2" NumberOfStrips="1" NumberOfVerts="0" NumberOfLines="0">
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0 4 0 0 4 4 0 2 1 0 0 4 0</DataArray></Points>
<Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 0 1 2 3 4</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3 8</DataArray></Polys>
<Strips><DataArray type="Int64" Name="connectivity" format="ascii">)" +
         strip + R"(</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray></Strips>
</Piece></PolyData></VTKFile>
)";
}

TEST(Vtp, ReadsPolygonsAndStrips) {
  const TempFolder folder;
  writeBytes(folder / "a.vtp", vtp("0 1 2 3"));
  ASSERT_VALUE(const auto mesh, readSurfaces(folder / "a.vtp"));
  ASSERT_EQ(mesh.triangles.size(), 1u + 3 + 2);
  double area = 0;
  for (int i = 1; i < 4; ++i) area += 0.5 * mesh.triangles[i].normal().z();
  EXPECT_NEAR(std::abs(area), 10, 1e-9);  // a square of 16 less the bay of 6
}

TEST(Vtp, ErrorsNameTheFile) {
  const TempFolder folder;
  writeBytes(folder / "b.vtp", vtp("0 1 2 9"));
  EXPECT_THAT(messageOf(folder / "b.vtp"), HasSubstr("b.vtp"));
  const std::string whole = vtp("0 1 2 3");
  for (std::size_t size = 0; size < whole.size() - 12; size += 101) {
    writeBytes(folder / "c.vtp", whole.substr(0, size));
    EXPECT_THAT(messageOf(folder / "c.vtp"), HasSubstr("c.vtp")) << size;
  }
}

#endif

}  // namespace
}  // namespace volute
