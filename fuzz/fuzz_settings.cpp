// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <string>

#include "fuzz/input_folder.hpp"
#include "volute/io/named_files.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/visibility/criteria_file.hpp"
#include "volute/visibility/study.hpp"

// Each reader of a small JSON file: criteria, studies, what a survey of a study found, cameras, and
// what looks for names in any of them. Errors are fine; limits and views that are no numbers are
// not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("settings");
  const std::string file =
      folder.save("visibility.json", volute::fuzz::textOf(data, size)).string();
  if (const auto criteria = volute::readCriteria(file)) {
    for (const volute::Criterion& criterion : *criteria) volute::fuzz::require(criterion.limit > 0);
  }
  if (const auto camera = volute::readCamera(file)) {
    const volute::View3 view = camera->viewAt(1);
    volute::fuzz::require(view.eye.allFinite() && view.target.allFinite());
  }
  (void)volute::Study::read(file);
  volute::StudyResults results("");
  if (results.add({}, folder.path()))
    (void)results.table();
  (void)volute::filesNamedIn(file);
  (void)volute::namesOutside(file);
  return 0;
}
