//! How the writer answers: first with what will hold once it is on disk, so that the words can be made while the disk
//! works, and then with whether it does.

use tokio::sync::mpsc;

use crate::pipeline::Reply;

#[derive(Debug)]
enum Message {
    /// What the answer will be, where the database takes it.
    Foretold(Vec<Reply>),
    /// What was foretold last is on disk.
    Holds,
    /// The answer, whatever was foretold.
    Told(Vec<Reply>),
}

/// The writer's end.
#[derive(Debug)]
pub(crate) struct ReplySender(mpsc::UnboundedSender<Message>);

/// The end of whoever waits.
#[derive(Debug)]
pub(crate) struct ReplyReceiver(mpsc::UnboundedReceiver<Message>);

pub(crate) fn channel() -> (ReplySender, ReplyReceiver) {
    // Unbounded, for the writer waits for nobody; it says a word or two.
    let (words, heard) = mpsc::unbounded_channel();
    (ReplySender(words), ReplyReceiver(heard))
}

impl ReplySender {
    pub fn foretell(&self, replies: Vec<Reply>) {
        self.say(Message::Foretold(replies));
    }

    /// What was foretold last has come true.
    pub fn hold(self) {
        self.say(Message::Holds);
    }

    pub fn tell(self, replies: Vec<Reply>) {
        self.say(Message::Told(replies));
    }

    fn say(&self, message: Message) {
        // Who has gone away is answered when it sends the same again.
        let _gone = self.0.send(message);
    }
}

impl ReplyReceiver {
    /// The replies when they hold, and what `put_into_words` makes of them: it is called as soon as they are
    /// foretold, and again where something else came true. None where the writer has gone without a final word.
    ///
    /// # Panics
    /// Where what was never foretold is said to hold.
    pub async fn hear<T>(mut self, mut put_into_words: impl FnMut(&[Reply]) -> T) -> Option<(Vec<Reply>, T)> {
        let mut foretold = None;
        loop {
            match self.0.recv().await? {
                Message::Foretold(replies) => {
                    let words = put_into_words(&replies);
                    foretold = Some((replies, words));
                }
                Message::Holds => return Some(foretold.expect("only what was foretold can hold")),
                Message::Told(replies) => {
                    let words = put_into_words(&replies);
                    return Some((replies, words));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::future::Future;
    use std::pin::pin;
    use std::task::{Context, Poll, Waker};

    use super::*;
    use crate::core::id::Id;
    use crate::pipeline::{Accepted, Refused, WriteError};

    fn stored(id: i64) -> Vec<Reply> {
        vec![Ok(Accepted::stored(Id(id)))]
    }

    fn id(replies: &[Reply]) -> Option<i64> {
        match replies {
            [Ok(Accepted::Stored { id, .. })] => Some(id.0),
            _ => None,
        }
    }

    /// What is worded, and what comes of it, when `words` have been said; a teller that is given back lives on.
    fn heard(
        words: impl FnOnce(ReplySender) -> Option<ReplySender>,
    ) -> (Vec<Option<i64>>, Poll<Option<(Option<i64>, Option<i64>)>>) {
        let (teller, listener) = channel();
        let _lives_on = words(teller);
        let mut worded = Vec::new();
        let heard = {
            let mut hearing = pin!(listener.hear(|replies| {
                worded.push(id(replies));
                id(replies)
            }));
            hearing.as_mut().poll(&mut Context::from_waker(Waker::noop()))
        };
        (worded, heard.map(|heard| heard.map(|(replies, worded)| (id(&replies), worded))))
    }

    #[test]
    fn what_is_foretold_is_worded_at_once_and_answered_only_when_it_holds() {
        let foretold = |teller: ReplySender| {
            teller.foretell(stored(1));
            Some(teller)
        };
        assert_eq!(heard(foretold), (vec![Some(1)], Poll::Pending));
        let held = heard(|teller| {
            teller.foretell(stored(1));
            teller.hold();
            None
        });
        assert_eq!(held, (vec![Some(1)], Poll::Ready(Some((Some(1), Some(1))))));
    }

    #[test]
    fn what_came_true_instead_is_worded_anew() {
        let otherwise = heard(|teller| {
            teller.foretell(stored(1));
            teller.foretell(stored(2));
            teller.tell(vec![Err(Refused::from(WriteError::Busy))]);
            None
        });
        assert_eq!(otherwise, (vec![Some(1), Some(2), None], Poll::Ready(Some((None, None)))));
        let again = heard(|teller| {
            teller.foretell(stored(1));
            teller.foretell(stored(2));
            teller.hold();
            None
        });
        assert_eq!(again, (vec![Some(1), Some(2)], Poll::Ready(Some((Some(2), Some(2))))));
    }

    #[test]
    fn a_writer_that_goes_without_a_final_word_has_stored_nothing_that_is_known() {
        let gone = heard(|teller| {
            teller.foretell(stored(1));
            None
        });
        assert_eq!(gone, (vec![Some(1)], Poll::Ready(None)));
    }
}
