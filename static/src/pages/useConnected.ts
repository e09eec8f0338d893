import { useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Picture } from "../render/picture/Picture";
import { type Connection, connect } from "../store/connect";
import { toast } from "../ui/Toast";
import { exposeHook } from "./debugHook";

interface Options {
  /** The picture of the map, if the view has one. */
  readonly picture?: { readonly current: Picture | null };
  /** The title of the page; without one that of the session. */
  readonly title?: string;
}

/** What is visible without a message, such as the end of a log. */
const SILENT = "log.end";

/** A view's connection to its session while the view is shown. The session's notices become toasts. */
export function useConnected(session: string, { picture, title }: Options = {}): Connection {
  const connection = useMemo(() => connect(session), [session]);
  useEffect(() => {
    exposeHook(connection, () => picture?.current ?? null);
    connection.start();
    return () => connection.stop();
  }, [connection]);
  const { store } = connection;
  useSignalEffect(() => {
    const notice = store.notice.value;
    if (notice && notice.code !== SILENT) toast(notice.message, notice.kind);
  });
  const shown = title ?? store.hello.value?.title;
  useEffect(() => {
    if (shown) document.title = `${shown} · Gridbloom`;
  }, [shown]);
  return connection;
}
