/** Whether viser's client has been told the scene of its present connection: before, it draws axes of its own. */

interface NodeMessage {
  readonly type?: string;
  readonly name?: unknown;
}

const isAboutAxes = ({ type, name }: NodeMessage): boolean =>
  type === "SetSceneNodeVisibilityMessage" && name === "/WorldAxes";

export class UntilTold {
  #hasAxes = false;
  #isDone = false;

  /** The client has a connection, for which it makes its own first scene again. */
  connected(): void {
    this.#hasAxes = this.#isDone = false;
  }

  /** Whether the server has told with these messages that its scene has no axes, and the first camera; true once. */
  isTold(messages: readonly NodeMessage[], hasCamera: boolean): boolean {
    this.#hasAxes ||= messages.some(isAboutAxes);
    if (this.#isDone || !this.#hasAxes || !hasCamera) return false;
    this.#isDone = true;
    return true;
  }
}
