// SPDX-License-Identifier: Apache-2.0
#include "plugin_file.hpp"

#include <elf.h>
#include <fmt/format.h>
#include <link.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>
#include <vector>

namespace waymark {
namespace {

using Header = ElfW(Ehdr);
using Segment = ElfW(Phdr);
using Section = ElfW(Shdr);
using Symbol = ElfW(Sym);

constexpr unsigned char kClass = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
constexpr unsigned char kByteOrder = std::endian::native == std::endian::little ? ELFDATA2LSB : ELFDATA2MSB;
#if defined(__x86_64__)
constexpr unsigned kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kMachine = EM_AARCH64;
#else
constexpr unsigned kMachine = EM_NONE;  // left to the dynamic linker
#endif

PluginError not_loadable(std::string_view reason) { return PluginError(fmt::format("cannot be loaded: {}", reason)); }

// Reads parts of a file, none of them beyond its end. Any offset and size may be asked for.
class Bytes {
 public:
  explicit Bytes(const std::filesystem::path& file) : stream_(file, std::ios::binary) {
    const int reason = errno;
    if (!stream_) {
      throw not_loadable(fmt::format("cannot open shared object file: {}", std::generic_category().message(reason)));
    }
    const auto end = stream_.seekg(0, std::ios::end).tellg();
    if (!stream_) throw not_loadable("it cannot be read");
    size_ = static_cast<std::uint64_t>(end);
  }

  std::uint64_t size() const { return size_; }

  // Throws if [offset, offset + size) reaches beyond the end.
  void require(std::uint64_t offset, std::uint64_t size) const {
    if (offset <= size_ && size <= size_ - offset) return;
    throw not_loadable(fmt::format("it is truncated or damaged: it has {} bytes, its headers name more", size_));
  }

  void read(std::uint64_t offset, void* to, std::size_t size) {
    require(offset, size);
    stream_.seekg(static_cast<std::streamoff>(offset));
    stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
    if (!stream_) throw not_loadable("it cannot be read");
  }

  // `count` is at most 65535, so the sizes of tables cannot overflow.
  template <class Entry>
  std::vector<Entry> read_table(std::uint64_t offset, std::uint16_t count) {
    require(offset, std::uint64_t{count} * sizeof(Entry));
    std::vector<Entry> entries(count);
    if (count > 0) read(offset, entries.data(), count * sizeof(Entry));
    return entries;
  }

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0;
};

Header read_header(Bytes& bytes) {
  Header header{};
  if (bytes.size() < sizeof header) throw not_loadable("file too short");
  bytes.read(0, &header, sizeof header);
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) throw not_loadable("invalid ELF header");
  if (header.e_ident[EI_CLASS] != kClass || header.e_ident[EI_DATA] != kByteOrder ||
      (kMachine != EM_NONE && header.e_machine != kMachine)) {
    throw not_loadable("it is built for another processor");
  }
  if (header.e_type != ET_DYN) throw not_loadable("it is not a shared library");
  if ((header.e_phnum != 0 && header.e_phentsize != sizeof(Segment)) ||
      (header.e_shnum != 0 && header.e_shentsize != sizeof(Section))) {
    throw not_loadable("invalid ELF header");
  }
  return header;
}

bool is_in_file(const Section& section) { return section.sh_type != SHT_NULL && section.sh_type != SHT_NOBITS; }

// Pages of a mapped file beyond its end cannot be read: the process would get SIGBUS.
void require_whole(Bytes& bytes, const Header& header, const std::vector<Section>& sections) {
  for (const Segment& segment : bytes.read_table<Segment>(header.e_phoff, header.e_phnum)) {
    bytes.require(segment.p_offset, segment.p_filesz);
  }
  for (const Section& section : sections) {
    if (is_in_file(section)) bytes.require(section.sh_offset, section.sh_size);
  }
}

std::optional<Section> find_record(Bytes& bytes, const Header& header, const std::vector<Section>& sections) {
  constexpr std::string_view kName(WAYMARK_PLUGIN_SECTION, sizeof WAYMARK_PLUGIN_SECTION);  // with its zero
  if (header.e_shstrndx >= sections.size()) return std::nullopt;
  const Section& names = sections[header.e_shstrndx];
  if (!is_in_file(names)) return std::nullopt;
  for (const Section& section : sections) {
    if (section.sh_type != SHT_PROGBITS) continue;
    if (section.sh_name > names.sh_size || names.sh_size - section.sh_name < kName.size()) continue;
    char name[kName.size()];
    bytes.read(names.sh_offset + section.sh_name, name, sizeof name);
    if (kName == std::string_view(name, sizeof name)) return section;
  }
  return std::nullopt;
}

// Where in the file the bytes are that will be mapped at `address`.
std::optional<std::uint64_t> offset_of(std::uint64_t address, std::uint64_t size,
                                       const std::vector<Segment>& segments) {
  for (const Segment& segment : segments) {
    if (segment.p_type != PT_LOAD || address < segment.p_vaddr) continue;
    const std::uint64_t within = address - segment.p_vaddr;
    if (within <= segment.p_filesz && size <= segment.p_filesz - within) return segment.p_offset + within;
  }
  return std::nullopt;
}

// Plugins before ABI 10 have no record, but `waymark_plugin`, which begins with its ABI.
std::optional<std::uint32_t> abi_of_symbol(Bytes& bytes, const Header& header, const std::vector<Section>& sections) {
  constexpr std::string_view kName("waymark_plugin", sizeof "waymark_plugin");  // with its zero
  for (const Section& section : sections) {
    if (section.sh_type != SHT_DYNSYM || section.sh_link >= sections.size()) continue;
    const Section& names = sections[section.sh_link];
    if (!is_in_file(names)) continue;
    for (std::uint64_t i = 0; i < section.sh_size / sizeof(Symbol); ++i) {
      Symbol symbol{};
      bytes.read(section.sh_offset + i * sizeof symbol, &symbol, sizeof symbol);
      if (symbol.st_shndx == SHN_UNDEF || symbol.st_name > names.sh_size ||
          names.sh_size - symbol.st_name < kName.size()) {
        continue;
      }
      char name[kName.size()];
      bytes.read(names.sh_offset + symbol.st_name, name, sizeof name);
      if (kName != std::string_view(name, sizeof name)) continue;
      std::uint32_t abi = 0;
      const auto offset =
          offset_of(symbol.st_value, sizeof abi, bytes.read_table<Segment>(header.e_phoff, header.e_phnum));
      if (!offset) return std::nullopt;
      bytes.read(*offset, &abi, sizeof abi);
      return abi;
    }
  }
  return std::nullopt;
}

void require_file(const std::filesystem::path& file) {
  if (const auto link = dangling_link(file); !link.empty()) throw PluginError(link);
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (error) throw PluginError(error.message());
  if (!std::filesystem::is_regular_file(status)) throw PluginError("is not a file");
}

PluginRecord read(const std::filesystem::path& file) {
  require_file(file);
  Bytes bytes(file);
  const Header header = read_header(bytes);
  const auto sections = bytes.read_table<Section>(header.e_shoff, header.e_shnum);
  require_whole(bytes, header, sections);
  const auto section = find_record(bytes, header, sections);
  PluginRecord record{};
  if (!section) {
    const auto abi = abi_of_symbol(bytes, header, sections);
    if (!abi) throw not_a_plugin();
    record.abi = *abi;
    return record;
  }
  // The record of another ABI may be shorter or longer; its number is at the start of each.
  bytes.read(section->sh_offset, &record, std::min<std::size_t>(section->sh_size, sizeof record));
  return record;
}

// Whether a text is there, ends, and can be printed on one line.
template <std::size_t N>
bool is_complete(const char (&field)[N]) {
  const std::string_view text = record_text(field);
  return !text.empty() && text.size() < N && std::none_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
}

}  // namespace

PluginRecord read_plugin_record(const std::filesystem::path& file) {
  try {
    return read(file);
  } catch (const PluginError& error) {
    throw PluginError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

std::optional<std::uint32_t> read_symbol_abi(const std::filesystem::path& file) {
  try {
    require_file(file);
    Bytes bytes(file);
    const Header header = read_header(bytes);
    return abi_of_symbol(bytes, header, bytes.read_table<Section>(header.e_shoff, header.e_shnum));
  } catch (const PluginError& error) {
    throw PluginError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

std::string misfit(const PluginRecord& record) {
  if (record.abi != kPluginAbi) {
    return fmt::format("built for plugin ABI {}, this program has {}; rebuild the plugin", record.abi, kPluginAbi);
  }
  if (!is_complete(record.build_key) || !is_complete(record.kind) || !is_complete(record.name) ||
      !is_complete(record.version)) {
    return "its descriptor is incomplete; use WAYMARK_PLUGIN(...)";
  }
  if (record_text(record.build_key) != kBuildKey) {
    return fmt::format("built with \"{}\", this program with \"{}\"; rebuild the plugin", record_text(record.build_key),
                       kBuildKey);
  }
  if (record.eigen_max_align != EIGEN_MAX_ALIGN_BYTES) {
    return fmt::format("built with an Eigen alignment of {} bytes, this program with {}; different -march?",
                       record.eigen_max_align, EIGEN_MAX_ALIGN_BYTES);
  }
  return {};
}

std::string plugin_name_of(const std::filesystem::path& file) {
  constexpr std::string_view kPrefix = "waymark_";
  const std::string stem = file.stem().string();
  if (file.extension() != ".so" || !stem.starts_with(kPrefix)) return {};
  return stem.substr(kPrefix.size());
}

std::string dangling_link(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error) || !std::filesystem::is_symlink(file, error)) return {};
  return fmt::format("is a dangling link to \"{}\"", std::filesystem::read_symlink(file, error).string());
}

PluginError not_a_plugin() {
  return PluginError(
      "is a library, but not a waymark plugin: it does not export \"waymark_plugin\" (is the line WAYMARK_PLUGIN(...) "
      "missing?)");
}

}  // namespace waymark
