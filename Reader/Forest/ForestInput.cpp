#include "Forest/ForestInput.h"

#include "Error.h"
#include "Forest/DealIIBlocks.h"
#include "Forest/PayloadGuess.h"

#include <algorithm>
#include <utility>

namespace treeamr
{
namespace
{

/// A layout that fits the size, to show what the property wants.
std::string examplePayload(std::size_t size, const std::string& name)
{
  for (const auto& [type, bytes] : { std::pair("double", 8), std::pair("float", 4), std::pair("char", 1) })
  {
    if (size % bytes == 0)
    {
      const std::size_t count = size / bytes;
      return std::string(type) + ' ' + name + (count > 1 ? '[' + std::to_string(count) + ']' : "");
    }
  }
  return {};
}

constexpr std::uint64_t sampleSize = std::uint64_t(1) << 16; // quadrants, of a few values each

PayloadReading guessPayload(const P4estForestFile& file)
{
  const std::size_t size = file.payloadSize();
  if (size == 0)
  {
    return {};
  }
  const std::string bytes = "the " + std::to_string(size) + " bytes of each quadrant are ";
  if (size != sizeof(double))
  {
    return { {},
      bytes + "left out, for their layout is unknown: set Payload to it, for example \"" +
        examplePayload(size, "value") + "\"." };
  }
  DoubleGuess guess;
  file.samplePayloads(sampleSize, [&guess](const std::byte* payload) { guess.add(payload); });
  const std::string objection = guess.objection();
  if (objection.empty())
  {
    return { { { "value", PayloadType::Float64, 1, 0 } },
      bytes +
        "read as \"double value\", which they look like: set Payload to say so, or what else they are." };
  }
  return { {},
    bytes + "left out, for it is unknown what they are: read as double they " + objection +
      ". Set Payload to their layout, for example \"double value\", \"long value\" or \"float value[2]\"." };
}

std::string blockCount(std::uint64_t count)
{
  return std::to_string(count) + (count == 1 ? " block" : " blocks");
}

/// Behind those of the blocks before, at the place of their own.
void appendFields(
  std::vector<PayloadField>& fields, std::vector<PayloadField> ofBlock, const DealIICellData::Block& block)
{
  for (PayloadField& field : ofBlock)
  {
    field.offset += block.offset;
    fields.push_back(std::move(field));
  }
}

/// Whether values of it depend on where in a cell they are.
bool isOfSpace(const DealIIBlock& block)
{
  return std::ranges::any_of(block.fields, [](const PayloadField& field) {
    return field.isAtCorners ||
      std::ranges::any_of(field.sums, [](const auto& terms) { return terms.size() > 1; });
  });
}

} // namespace

ForestInput::ForestInput(const std::string& path)
  : ForestInput(path, DealIIInfo::find(path))
{
}

ForestInput::ForestInput(const std::string& path, std::optional<DealIIInfo> info)
  : info_(std::move(info))
  , forest_(info_ ? info_->base : path)
{
  if (info_)
  {
    cells_.emplace(*info_, forest_);
  }
}

bool ForestInput::canRead(const std::string& path) noexcept
{
  return P4estForestFile::hasMagic(path) || DealIIInfo::isOne(path);
}

std::vector<PayloadField> ForestInput::fieldsOf(const std::string& path, const std::string& text)
{
  if (!DealIIInfo::pathOf(path))
  {
    return PayloadLayout::parse(text).fields();
  }
  std::vector<PayloadField> fields;
  for (DealIIBlock& block : parseDealIIBlocks(text))
  {
    appendFields(fields, std::move(block.fields), {});
  }
  return fields;
}

PayloadReading ForestInput::readPayload(const std::string& text) const
{
  if (info_)
  {
    PayloadReading reading = text.empty() ? guessBlocks() : readBlocks(text);
    if (info_->variableBlocks > 0)
    {
      reading.remark += reading.remark.empty() ? "" : " ";
      reading.remark += "left out: " + blockCount(info_->variableBlocks) + " of variable size, in " +
        info_->base + "_variable.data.";
    }
    return reading;
  }
  if (text.empty())
  {
    return guessPayload(forest_);
  }
  const PayloadLayout layout = PayloadLayout::parse(text);
  if (layout.size() != forest_.payloadSize())
  {
    throw Error(forest_.path() + ": payload \"" + text + "\" takes " + std::to_string(layout.size()) +
      " bytes, allowed the " + std::to_string(forest_.payloadSize()) + " bytes per quadrant of the file" +
      (forest_.payloadSize() == 0 ? "; leave Payload empty for forests saved without data"
                                  : "; name all members of the struct, with pad[n] for bytes to leave out"));
  }
  return { layout.fields(), {} };
}

PayloadReading ForestInput::readBlocks(const std::string& text) const
{
  const std::vector<DealIIBlock> said = parseDealIIBlocks(text);
  const std::vector<DealIICellData::Block>& blocks = cells_->blocks();
  if (said.size() != blocks.size())
  {
    std::string sizes;
    for (const DealIICellData::Block& block : blocks)
    {
      sizes += (sizes.empty() ? ", of " : ", ") + std::to_string(block.size);
    }
    throw Error(info_->path + ": payload \"" + text + "\" is of " + blockCount(said.size()) + ", allowed " +
      std::to_string(blocks.size()) + ", as many as deal.II attached to each cell" +
      (blocks.empty() ? ": leave Payload empty" : sizes + " bytes; skip is for one to leave out"));
  }
  PayloadReading reading;
  for (std::size_t b = 0; b < blocks.size(); ++b)
  {
    if (said[b].skipped)
    {
      continue;
    }
    if (said[b].size != blocks[b].size)
    {
      const bool isMissingVectors =
        !said[b].fields.empty() && !said[b].fields[0].sums.empty() && blocks[b].size % said[b].size == 0;
      throw Error(cells_->path() + ": payload \"" + said[b].text + "\" takes " +
        std::to_string(said[b].size) + " bytes, allowed the " + std::to_string(blocks[b].size) +
        " bytes per cell of block " + std::to_string(b + 1) +
        (isMissingVectors ? "; name all of its vectors, which may be " +
              std::to_string(blocks[b].size / said[b].size) + " times as many"
                          : ""));
    }
    if (forest_.dimension() == 2 && isOfSpace(said[b]))
    {
      throw Error(cells_->path() + ": payload \"" + said[b].text +
        "\" is of elements in three dimensions, allowed in the two of this forest are FE_DGQ(0), members and "
        "skip");
    }
    appendFields(reading.fields, said[b].fields, blocks[b]);
  }
  return reading;
}

/// Of 8 and 64 bytes: one value a cell, or those of its eight corners.
PayloadReading ForestInput::guessBlocks() const
{
  const std::vector<DealIICellData::Block>& blocks = cells_->blocks();
  if (blocks.empty())
  {
    return {};
  }
  std::vector<DoubleGuess> guesses(blocks.size());
  const auto isCandidate = [this](const DealIICellData::Block& block) {
    return block.size == sizeof(double) || (block.size == 8 * sizeof(double) && forest_.dimension() == 3);
  };
  if (std::ranges::any_of(blocks, isCandidate))
  {
    cells_->sample(sampleSize, [&](const std::byte* cell) {
      for (std::size_t b = 0; b < blocks.size(); ++b)
      {
        for (std::size_t at = 0; isCandidate(blocks[b]) && at < blocks[b].size; at += sizeof(double))
        {
          guesses[b].add(cell + blocks[b].offset + at);
        }
      }
    });
  }
  PayloadReading reading;
  reading.remark = "of the " + blockCount(blocks.size()) + " that deal.II attached to each cell, ";
  std::string example;
  for (std::size_t b = 0; b < blocks.size(); ++b)
  {
    const std::string number = std::to_string(b + 1);
    std::string text = "skip";
    std::string found = "left out";
    if (isCandidate(blocks[b]))
    {
      const std::string objection = guesses[b].objection();
      if (objection.empty())
      {
        text = "double block" + number + (blocks[b].size == sizeof(double) ? " = FE_DGQ(0)" : " = FE_Q(1)");
        found = "read as \"" + text + '"';
        appendFields(reading.fields, parseDealIIBlocks(text)[0].fields, blocks[b]);
      }
      else
      {
        found += " (as double they " + objection + ')';
      }
    }
    else if (blocks[b].size > 0)
    {
      text = examplePayload(blocks[b].size, "block" + number);
    }
    reading.remark += (b == 0 ? "number " : ", number ") + number + ", of " + std::to_string(blocks[b].size) +
      " bytes, is " + found;
    example += (b == 0 ? "" : "; ") + text;
  }
  reading.remark += ". Set Payload to what they are, for example \"" + example +
    "\": vectors of finite elements as \"double u, v = FE_Q(2)\", by what deal.II's get_name() says, and "
    "skip for what "
    "to leave out.";
  return reading;
}

void ForestInput::readQuadrants(bool withPayload, std::span<const LeafRange> ranges, LeafBlock& block) const
{
  forest_.readQuadrants(ranges, block);
  if (!withPayload || !cells_ || cells_->blocks().empty())
  {
    return;
  }
  const QuadrantRecords records = cells_->records();
  block.payloads.resize(block.leaves.size() * records.recordBytes());
  std::byte* payload = block.payloads.data();
  for (const LeafRange& range : ranges)
  {
    records.read(range.begin, range.count(), payload);
    payload += range.count() * records.recordBytes();
  }
  payload = block.payloads.data();
  for (TreeLeaf& leaf : block.leaves)
  {
    leaf.payload = payload;
    payload += records.recordBytes();
    cells_->checkStatus(leaf.number, leaf.payload);
  }
}

std::uint64_t ForestInput::blockQuadrants() const noexcept
{
  const std::uint64_t ofForest = forest_.blockQuadrants();
  return cells_ && !cells_->blocks().empty()
    ? std::clamp<std::uint64_t>(P4estInputFile::blockBytes / 2 / cells_->records().recordBytes(), 1, ofForest)
    : ofForest;
}

} // namespace treeamr
