// cupola devices: what this machine has, in both forms.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <set>

#include <nlohmann/json.hpp>

#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

class Devices : public ProgramTest {};

TEST_F(Devices, AreListedAsATableAndAsJson) {
  const Outcome table = call({"devices"});
  EXPECT_EQ(table.code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("KIND"));
  const Outcome json = call({"devices", "--json"});
  EXPECT_EQ(json.code, 0) << json.err;
  std::set<std::string> kinds;
  for (const nlohmann::json& row : nlohmann::json::parse(json.out)) {
    kinds.insert(row["kind"].get<std::string>());
    EXPECT_NE(row["usable"].get<bool>(), row["name"].empty() || !row["problem"].get<std::string>().empty());
    EXPECT_THAT(table.out, HasSubstr(row["problem"].get<std::string>()));
  }
  for (const char* kind : {"camera", "gpio", "display", "gl"}) EXPECT_TRUE(kinds.contains(kind)) << kind;
}

}  // namespace
}  // namespace cupola
