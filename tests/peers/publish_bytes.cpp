// SPDX-License-Identifier: Apache-2.0
// publish_bytes DOMAIN: publishes lines "TOPIC TYPE HEX" of the standard input, each as one sample of these bytes,
// whatever they are.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "plugins/shared/dds/writer.hpp"

int main(int argc, char** argv) {
  using namespace waymark::dds;
  if (argc != 2) return 2;
  try {
    const Participant participant({static_cast<std::uint32_t>(std::stoul(argv[1])), "lo"});
    std::map<std::string, std::unique_ptr<Writer>> writers;
    std::string topic, type, hex;
    while (std::cin >> topic >> type >> hex) {
      auto& writer = writers[topic];
      if (!writer) writer = std::make_unique<Writer>(participant, topic, type, Quality{}, std::chrono::seconds(1));
      std::vector<std::uint8_t> bytes;
      for (std::size_t at = 0; at + 1 < hex.size(); at += 2)
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(at, 2), nullptr, 16)));
      writer->write(std::move(bytes));
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "publish_bytes: %s\n", error.what());
    return 1;
  }
}
