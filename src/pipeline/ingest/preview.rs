//! What storing would come to, without storing.

use super::admit::{Admission, Ahead, Group, Memory};
use super::same_content::Origin;
use crate::core::note::Note;
use crate::pipeline::prelude::*;
use crate::pipeline::{Ingest, Refused, Submission};
use crate::store::IdSource;

/// Beyond every identifier of this century.
const NEVER_STORED: i64 = i64::MAX - (1 << 40);

/// What would become of a document.
#[derive(Debug, Clone)]
pub enum Preview {
    /// It would be stored with these notes, or is there already and says the same.
    Taken {
        notes: Arc<[Note]>,
    },
    Refused(Refused),
    /// An earlier one of these documents, counted from 0, holds its place with other content.
    Contradicts(usize),
}

impl Ingest {
    /// What would become of each of these documents if they were stored now, in this order: admitted to a group that is
    /// then dropped. Each takes queries of its own. Somebody else may store something in between.
    pub async fn preview(&self, documents: &[&Submission]) -> Vec<Preview> {
        let origins: Vec<Option<Origin>> = documents.iter().map(|sent| Origin::of(sent)).collect();
        // Its identifiers are seen by nobody; they only have to differ from those that are stored.
        let mut ids = IdSource::after(NEVER_STORED);
        let (mut memory, ahead, nobody) = (Memory::default(), Ahead::default(), Actor::by_caller());
        let mut admission = Admission {
            store: &self.store,
            ids: &mut ids,
            memory: &mut memory,
            ahead: &ahead,
            judging: &self.config.judging,
            epochs: &self.config.plausibility.clock_epochs,
            now: self.clock.now(),
            by: &nobody,
        };
        let (mut group, mut new) = (Group::default(), HashMap::new());
        let mut previews = Vec::with_capacity(documents.len());
        for (place, document) in documents.iter().enumerate() {
            let admitted = admission.admit(document, &mut group).await;
            if let Ok(Accepted::Stored { id, .. }) = &admitted {
                new.insert(*id, place);
            }
            previews.push(self.outcome(admitted, place, &origins, &new).await);
        }
        previews
    }

    /// `new`: which document would be stored under an identifier.
    async fn outcome(
        &self,
        admitted: Result<Accepted, Refused>,
        place: usize,
        origins: &[Option<Origin>],
        new: &HashMap<Id, usize>,
    ) -> Preview {
        match admitted {
            Ok(Accepted::Stored { notes, .. }) => Preview::Taken { notes },
            Ok(Accepted::There { counts: false, .. }) => Preview::Taken { notes: [Note::Withdrawn].into() },
            Ok(there @ Accepted::There { id, same_bytes, .. }) => match new.get(&id) {
                Some(&first) if same_bytes || Origin::say_the_same(&origins[first], &origins[place]) => {
                    Preview::Taken { notes: [].into() }
                }
                Some(&first) => Preview::Contradicts(first),
                None => match self.settle(&there, origins[place].as_ref()).await {
                    Ok(_) => Preview::Taken { notes: [].into() },
                    Err(refused) => Preview::Refused(refused),
                },
            },
            Err(Refused::GyroElsewhere { existing, .. }) if new.contains_key(&existing) => {
                Preview::Contradicts(new[&existing])
            }
            Err(refused) => Preview::Refused(refused),
        }
    }
}
