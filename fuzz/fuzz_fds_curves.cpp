// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/media/fds/fds_conditions.hpp"

// CHID_hrr.csv and CHID_devc.csv of a case with two devices. Errors are fine; curves whose times
// and values are not as many are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("fds_curves");
  volute::SmvIndex index;
  index.path = folder.path() / "a.smv";
  index.chid = "a";
  index.devices.push_back({"T1", "TEMPERATURE", volute::Vec3(1, 1, 1), false, {}});
  index.devices.push_back({"T2", "TEMPERATURE", volute::Vec3(2, 1, 1), false, {}});
  for (const char* name : {"a_hrr.csv", "a_devc.csv"})
    folder.save(name, volute::fuzz::textOf(data, size));
  const volute::CaseFacts facts = volute::fdsFacts(index);
  for (const auto* curves : {&facts.fire, &facts.devices}) {
    for (const volute::FactCurve& curve : *curves)
      volute::fuzz::require(!curve.times.empty() && curve.times.size() == curve.values.size());
  }
  const auto field = volute::fdsConditions(index, "temperature", 1 << 20);
  if (!field)
    return 0;
  const volute::Vec3 point(1, 1, 1);
  double value = 0;
  for (const double time : (*field)->times()) (void)(*field)->at(time, {&point, 1}, {&value, 1});
  return 0;
}
