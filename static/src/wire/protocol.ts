/**
 * The wire protocol in the pages. The messages and commands are generated from the server's (`messages.ts`), the text
 * frames are read by `decodeText.ts` and the binary ones by `decodeFrame.ts`. `protocol.vectors.json` is written by the
 * server's tests and read by those of the pages.
 */

import type { Command, FrameMessage, Geometry } from "./messages";

export type {
  BrushStroke,
  CellMessage,
  CellState,
  ClassAxis,
  ClassCommand,
  ClassLook,
  ClassMessage,
  ClassPuzzle,
  ClassQuestion,
  ClassSlide,
  ClassSolver,
  ClassState,
  ClassView,
  ClassViewMessage,
  ClassWelcome,
  Command,
  Compared,
  ComparisonMessage,
  Contribution,
  CostMessage,
  CostmapMessage,
  DrawnSolid,
  Edits,
  Forgetting,
  FrameMessage,
  Geometry,
  Hello,
  LayerCost,
  LayerInfo,
  LayerKind,
  LocalizationMessage,
  LogInfo,
  Map3dMessage,
  MapEditCommand,
  MapEditsMessage,
  Numbers,
  Parameter,
  ParametersMessage,
  PathMessage,
  PickedMessage,
  Point,
  Pose,
  ServerMessage,
  SurfaceMessage,
  SurfaceVoxelMessage,
  Table,
  Trajectory,
  Value,
  Values,
  VolumeMessage,
  VoxelMessage,
  WhyMessage,
  WorkingMessage,
  WorldMessage,
} from "./messages";
export { CLOSE_SENTENCES, ENDED, MAYBE_OVER, SUBPROTOCOL } from "./messages";

/** Cells along the side of a tile. */
export const TILE: Geometry["tile"] = 64;

/** The newest state with the newest scan, which only some of the frame messages contain. */
export type Frame = FrameMessage &
  Required<Pick<FrameMessage, "scan_pose" | "ranges" | "angle_min" | "angle_increment" | "range_max">>;

/** An invalid frame; `code` is stable, the message is one sentence. */
export class ProtocolError extends Error {
  readonly code: string;

  constructor(code: string, message: string) {
    super(message);
    this.name = "ProtocolError";
    this.code = code;
  }
}

/** Write a command. */
export function encodeCommand(command: Command): string {
  return JSON.stringify(command);
}
