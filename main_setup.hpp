// SPDX-License-Identifier: Apache-2.0
// What the board and the command line say together, as the configurations of the parts.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "board/board.hpp"
#include "hal/messages.hpp"
#include "hal/result.hpp"
#include "hal/sim/map_world.hpp"
#include "main_commands.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/mapper.hpp"
#include "mapper/pipeline.hpp"
#include "mapper/report.hpp"

namespace g3d {

/// The board of the file, or the built-in one, with what the command line says instead.
[[nodiscard]] hal::Result<board::Board> effective_board(const MappingOptions& options);
[[nodiscard]] mapper::MapperConfig mapper_config(const board::Board& board, const MappingOptions& options);
[[nodiscard]] hal::CameraModel camera_model(const board::Board& board);
/// A sentence if the command line insists on a card and the mapper has none.
[[nodiscard]] std::optional<std::string> missing_card(const mapper::Mapper& mapper, const MappingOptions& options);
/// Says in the report where the map was computed.
void report_mapper(const mapper::Mapper& mapper, mapper::RunReport& report);
/// The same, and what is in a map that lies in memory as a whole.
void report_map(const mapper::Mapper& mapper, mapper::RunReport& report);
/// T_base_camera of the camera as the board has it mounted.
[[nodiscard]] hal::Pose mount_pose(const board::Board& board);
/// `text`: "X0,Y0,X1,Y1" in metres, or empty for none. `option` is what errors (bad_usage) call it.
[[nodiscard]] hal::Result<std::optional<hal::FloorRectangle>> choose_rectangle(std::string_view option,
                                                                               const std::string& text);
/// How poses are corrected; none if they are taken as given.
[[nodiscard]] std::optional<mapper::align::AlignOptions> align_options(const MappingOptions& options);
/// A sentence if the command line asks for loops and for what does not go with them.
[[nodiscard]] std::optional<std::string> loops_problem(const MappingOptions& options);
/// What came of it, for the report; nothing if `aligner` is nullptr.
void report_alignment(const mapper::align::Aligner* aligner, const MappingOptions& options, mapper::RunReport& report);
/// None if the command line asks for none. The error is one of usage.
[[nodiscard]] hal::Result<std::optional<mapper::StartFootprint>> start_footprint(const board::Board& board,
                                                                                 const MappingOptions& options);

}  // namespace g3d
