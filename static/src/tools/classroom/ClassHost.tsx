import { classroom, followedCode } from "../../store/classroom";
import { Button } from "../../ui/Button";
import "./classroom.css";
import "./questions.css";
import { FollowerBar } from "./FollowerBar";
import { LecturerBar } from "./LecturerBar";
import { openClassHere } from "./opening";

/** The class of this page, at the bottom of the page; once on each page. */
export function ClassHost() {
  const room = classroom.value;
  if (!room) return null;
  return room.isFollowed ? <FollowerBar room={room} /> : <LecturerBar room={room} />;
}

/** Opens a class. Not shown while there is one, and on the pages of followers. */
export function ClassButton({ iconOnly = false }: { readonly iconOnly?: boolean }) {
  if (classroom.value || followedCode !== null) return null;
  if (iconOnly)
    return (
      <Button
        icon="people"
        label="Open a class: others follow on their own devices"
        onClick={() => void openClassHere()}
      />
    );
  return (
    <Button kind="quiet" icon="people" label="Class" onClick={() => void openClassHere()}>
      <span class="class-button-text">Class</span>
    </Button>
  );
}
