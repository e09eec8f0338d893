/** Whether viser's client has received the scene of its present connection; before that it draws its own axes. */

interface ToldMessage {
  readonly type?: string;
  readonly name?: unknown;
  readonly initial?: boolean;
}

const isAboutAxes = ({ type, name }: ToldMessage): boolean =>
  type === "SetSceneNodeVisibilityMessage" && name === "/WorldAxes";

const isAim = ({ type, initial }: ToldMessage): boolean => type === "SetCameraPositionMessage" && !initial;

export class UntilTold {
  #hasAxes = false;
  #isAimed = false;
  #isDone = false;

  /** The client has a connection, for which it creates its initial scene again. */
  connected(): void {
    this.#hasAxes = this.#isAimed = this.#isDone = false;
  }

  /**
   * Whether the server has told with these messages that its scene has no axes, the first camera and, unless that `isMoved`
   * by a person, the one for the shape of this view, which would undo what a person does before; true once.
   */
  isTold(messages: readonly ToldMessage[], hasCamera: boolean, isMoved: boolean): boolean {
    this.#hasAxes ||= messages.some(isAboutAxes);
    this.#isAimed ||= messages.some(isAim);
    if (this.#isDone || !this.#hasAxes || !hasCamera || !(this.#isAimed || isMoved)) return false;
    this.#isDone = true;
    return true;
  }
}
